#pragma once
/// What an archive holds beside the engine's own events and results, and the variant of all of it.

#include <Eigen/Core>
#include <cstdint>
#include <downrange/geo/frames.hpp>
#include <downrange/geo/name.hpp>
#include <downrange/geo/time.hpp>
#include <downrange/stage/catalogue.hpp>
#include <stdexcept>
#include <string>

namespace downrange::archive {

/// The last tick the engine ran; {INT64_MIN} when it ran none.
struct LastTick {
  Time tick;
};

/// Where a target truly was. Written by the simulator or an importer for analysis; the engine never reads it.
struct Truth {
  Name target;
  Time epoch;
  Position<Ecef> position;
  Velocity<Ecef> velocity;
  Eigen::Vector3d acceleration_m_s2 = Eigen::Vector3d::Zero();  ///< relative to the Earth, ECEF axes
  bool acceleration_valid = false;
};

/// A message of one of our channels whose content is not a legal record (its chunk's checksum was right).
struct BadRecord {
  std::string topic;
  std::string what;
};

/// Every kind of record once. The place is the record's kind and, plus one, the id of its schema. Free to change: a
/// file says itself what its ids mean.
using Records = decltype(Inputs{} + RecordList<ClockGap>{} + Outputs{} + RecordList<LastTick, Truth>{});
using Record = Records::Variant<BadRecord>;

/// Which side of the engine a message was on. An Observation can be either: consumed by a centre, made by an ingest.
enum class Role : std::uint8_t { Input, Output, Mark, Truth };

/// A file that cannot be opened, is not MCAP, or is damaged. The text names file, byte offset and what is wrong.
class ArchiveError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace downrange::archive
