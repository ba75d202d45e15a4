#pragma once
/// Inside src/dds: conversions of single fields.

#include <algorithm>
#include <array>
#include <downrange/geo/name.hpp>
#include <string>

#include "dds/convert.hpp"

namespace downrange::dds {

/// Collects the first defect of a sample.
class Check {
 public:
  /// A name that is needed: an empty one could stand for any source.
  void name(const char* field, const char* from, Name& to) {
    text(field, from, to);
    if (to.empty()) fail(field, "is empty");
  }
  template <std::size_t MaxSize>
  void text(const char* field, const char* from, FixedText<MaxSize>& to) {
    if (const auto parsed = FixedText<MaxSize>::parse(from)) {
      to = *parsed;
    } else {
      fail(field, "is longer than " + std::to_string(MaxSize) + " characters");
    }
  }
  /// `last`: the largest enumerator of To, which the wire's enumerators equal in number.
  template <class To, class From>
  void enumerator(const char* field, From from, To last, To& to) {
    if (static_cast<std::uint32_t>(from) <= static_cast<std::uint32_t>(last)) {
      to = static_cast<To>(static_cast<std::uint32_t>(from));
    } else {
      fail(field, "holds enumerator " + std::to_string(static_cast<std::uint32_t>(from)));
    }
  }
  void fail(const char* field, const std::string& what) {
    if (defect_.empty()) defect_ = std::string(field) + " " + what;
  }
  [[nodiscard]] Defect defect() { return std::move(defect_); }

 private:
  Defect defect_;
};

/// What the wire's sequence of IntegrityV3 holds.
inline constexpr std::size_t max_integrity_sources = 64;

inline void copy(const Eigen::Vector3d& from, std::array<double, 3>& to) { to = {from.x(), from.y(), from.z()}; }
inline void copy(const std::array<double, 3>& from, Eigen::Vector3d& to) { to = {from[0], from[1], from[2]}; }

/// Same numbers on both sides: src/dds/convert_*.cpp asserts that the last enumerators agree.
template <class To, class From>
[[nodiscard]] To same_number(From from) {
  return static_cast<To>(static_cast<std::uint32_t>(from));
}

}  // namespace downrange::dds
