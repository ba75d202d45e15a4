#pragma once
/// Quality of service for tests on a machine that is busy with others.

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <source_dir.hpp>
#include <string>

namespace downrange::dds {

/// The profiles with a lease and deadlines of 3 s: a node that a busy machine keeps waiting must not count as dead.
class PatientProfiles {
 public:
  PatientProfiles() {
    std::string name = std::filesystem::temp_directory_path() / "dds_ownership_test.XXXXXX";
    ::close(::mkstemp(name.data()));
    path = name;
    std::ifstream file(std::string(DOWNRANGE_SOURCE_DIR) + "/config/dds-qos.xml");
    std::string text{std::istreambuf_iterator<char>(file), {}};
    for (const std::string element : {"lease_duration", "period"}) {
      const std::string begin = "<" + element + ">";
      for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at + 1)) {
        text.replace(at + begin.size(), text.find("</" + element, at) - at - begin.size(), "<sec>3</sec>");
      }
    }
    std::ofstream(path) << text;
  }
  ~PatientProfiles() { std::filesystem::remove(path); }
  PatientProfiles(const PatientProfiles&) = delete;
  PatientProfiles& operator=(const PatientProfiles&) = delete;
  std::filesystem::path path;
};

}  // namespace downrange::dds
