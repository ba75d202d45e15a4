#include "shipped_files.hpp"

namespace downrange::app {

namespace fs = std::filesystem;

fs::path shipped_file(const fs::path& name) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    fs::path installed = program.parent_path().parent_path() / "share" / "downrange" / name;
    if (fs::exists(installed, error)) return installed;
  }
  const fs::path sources = DOWNRANGE_SOURCE_DIR;
  return *name.begin() == "config" ? sources / name : sources / "tools" / name;
}

}  // namespace downrange::app
