#pragma once

#include <stdexcept>

namespace downrange::archive {

/// A mapping or a file that cannot be imported. The text names file, line, key and what is allowed.
class ImportError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace downrange::archive
