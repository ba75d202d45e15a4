// Every record comes back as it was written: field by field, bit by bit, in every compression.

#include <archive/record_catalogue.hpp>
#include <bit>
#include <limits>
#include <numeric>
#include <set>

#include "archive_testing.hpp"

namespace downrange::archive {
namespace {

// Comparing the messages compares every field, and a field that to_proto or from_proto forgot shows as a default.
template <class T>
void expect_round_trip(const T& in) {
  Proto<T> message;
  to_proto(in, message);
  Defect defect;
  const T back = from_proto(message, defect);
  Proto<T> again;
  to_proto(back, again);
  EXPECT_EQ(defect.what, "");
  EXPECT_EQ(message.SerializeAsString(), again.SerializeAsString()) << message.ShortDebugString();
  if constexpr (requires { in == back; }) {
    EXPECT_TRUE(in == back) << message.ShortDebugString();
  }
}

/// Read from older archives, written no more.
constexpr const char* only_read = "downrange.record.SourceHealth.count";

/// The samples together set every field of the message.
template <class T>
void expect_every_field(const std::vector<T>& samples) {
  std::set<std::string> left_out;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    Proto<T> message;
    to_proto(samples[i], message);
    const auto* descriptor = message.GetDescriptor();
    for (int f = 0; f < descriptor->field_count(); ++f) {
      const auto* field = descriptor->field(f);
      if (field->full_name() == only_read) continue;
      const auto* reflection = message.GetReflection();
      const bool set =
          field->is_repeated() ? reflection->FieldSize(message, field) > 0 : reflection->HasField(message, field);
      if (i == 0 && !set) left_out.insert(field->full_name());
      if (set) left_out.erase(field->full_name());
    }
  }
  for (const std::string& field : left_out) ADD_FAILURE() << field << ": no sample sets it, or to_proto forgets it";
}

template <class T>
std::vector<T> samples_of() {
  if constexpr (std::is_same_v<T, Observation>) {
    std::vector<Observation> samples{test::sample_observation_of(test::sample_measured_plot()),
                                     test::sample_observation_of(test::sample_measured_fix()),
                                     test::sample_observation_of(Angles{1, 0.5})};
    for (Observation& o : samples) o.step = 99;
    return samples;
  } else if constexpr (std::is_same_v<T, LastTick>) {
    return {LastTick{t0}};
  } else if constexpr (std::is_same_v<T, ClockGap>) {
    return {ClockGap{.epoch = t0 + milliseconds(7), .received = t0}};
  } else if constexpr (std::is_same_v<T, Truth>) {
    return {some_truth()};
  } else if constexpr (std::is_same_v<T, AntennaReport>) {
    AntennaReport other = test::sample<AntennaReport>();
    other.elevation_valid = true;
    return {test::sample<AntennaReport>(), other};
  } else {
    return {test::sample<T>()};
  }
}

TEST(ArchiveRecord, EveryFieldSurvives) {
  Records::for_each([]<class T>() {
    const std::vector<T> samples = samples_of<T>();
    expect_every_field(samples);
    for (const T& sample : samples) expect_round_trip(sample);
  });
  for (int terms = 1; terms <= max_bias_terms; ++terms) expect_round_trip(some_bias(terms));
  for (int size : {6, 9}) expect_round_trip(some_trajectory(size));
}

// Archives of 0.1.0 have no validity flags: what they do not say is as it was meant then.
TEST(ArchiveRecord, AnArchiveWithoutValidityFlagsMeansWhatItMeant) {
  Defect defect;
  record::RadarTspi radar;
  RadarTspi plot = from_proto(radar, defect);
  EXPECT_TRUE(plot.range_valid && plot.azimuth_valid && plot.elevation_valid);
  EXPECT_FALSE(plot.snr_valid);
  radar.set_snr_db(12);
  EXPECT_TRUE(from_proto(radar, defect).snr_valid);
  record::GpsFix fix;
  EXPECT_FALSE(from_proto(fix, defect).satellites_valid);
  fix.set_satellites(7);
  EXPECT_TRUE(from_proto(fix, defect).satellites_valid);
  fix.set_satellites(0);
  fix.set_satellites_valid(true);
  EXPECT_TRUE(from_proto(fix, defect).satellites_valid) << "stated: none";
  const AngleTspi angles = from_proto(record::AngleTspi(), defect);
  EXPECT_TRUE(angles.azimuth_valid && angles.elevation_valid);
  const Observation observation = from_proto(record::Observation(), defect);
  EXPECT_TRUE(std::get<Plot>(observation.measured).range_valid && std::get<Plot>(observation.measured).angles_valid);
  EXPECT_EQ(defect.what, "");
}

TEST(ArchiveRecord, EveryFieldOfTheMessageMeansTheFieldOfTheStruct) {
  record::RadarTspi radar;
  to_proto(some_radar(3), radar);
  EXPECT_EQ(radar.sensor(), "goheung");
  EXPECT_EQ(radar.received_ns() - radar.epoch_ns(), 40'000'000);
  EXPECT_EQ(radar.range_m(), 12'348.678);
  EXPECT_EQ(radar.azimuth_rad(), 1.25);
  EXPECT_EQ(radar.elevation_rad(), 0.5);
  EXPECT_EQ(radar.mode(), record::TRACK_MODE_COAST);

  record::AngleTspi angles;
  to_proto(some_angles(), angles);
  EXPECT_EQ(angles.sensor(), "optical");
  EXPECT_EQ(angles.received_ns() - angles.epoch_ns(), 70'000'000);
  EXPECT_EQ(angles.azimuth_rad(), 3.25);
  EXPECT_EQ(angles.elevation_rad(), 0.75);
  EXPECT_EQ(angles.mode(), record::TRACK_MODE_ACQUIRE);

  record::Trajectory trajectory;
  to_proto(some_trajectory(9), trajectory);
  EXPECT_EQ(trajectory.state_size(), 9);
  EXPECT_EQ(trajectory.covariance_size(), 45);
  EXPECT_EQ(trajectory.latitude_rad(), 0.6);
  EXPECT_EQ(trajectory.quality(), record::TRACK_QUALITY_COASTING);

  record::SlavingCommand slaving;
  to_proto(some_slaving(), slaving);
  EXPECT_EQ(slaving.source(), record::SLAVING_SOURCE_NOMINAL);
  EXPECT_EQ(slaving.limits(), 9u);

  record::Observation observation;
  to_proto(some_observation(), observation);
  EXPECT_EQ(observation.verdict(), record::REASON_FROZEN);
  EXPECT_EQ(observation.position_y_m(), 4.2e6);
  EXPECT_EQ(observation.velocity_z_m_s(), -3);
  EXPECT_TRUE(observation.simulated());

  record::SourceHealth health;
  to_proto(some_health(), health);
  EXPECT_EQ(health.why(), record::DISQUALIFICATION_REJECTED);
  EXPECT_EQ(health.rejected_for(), record::REASON_FROZEN);
  EXPECT_EQ(health.nis_inside_95(), 0.925);
  EXPECT_EQ(health.nis_count(), 1000u);
  EXPECT_TRUE(health.mismatch());
}

// The enumerations are written by number: C++ and Protobuf must count alike.
TEST(ArchiveRecord, EnumerationsEndAlike) {
  EXPECT_EQ(static_cast<int>(record::Reason_MAX), static_cast<int>(reason_count) - 1);
  EXPECT_EQ(static_cast<int>(record::ObservationKind_MAX), static_cast<int>(std::variant_size_v<Measured>) - 1);
  EXPECT_EQ(static_cast<int>(record::BiasTerm_MAX), static_cast<int>(BiasTerm::TimeTag));
  EXPECT_EQ(static_cast<int>(record::BiasState_MAX), static_cast<int>(BiasState::Frozen));
  EXPECT_EQ(static_cast<int>(record::SlavingSource_MAX), static_cast<int>(SlavingSource::Nominal));
  EXPECT_EQ(static_cast<int>(record::Disqualification_MAX), static_cast<int>(Disqualification::Excluded));
  EXPECT_EQ(static_cast<int>(record::IntegrityVerdict_MAX), static_cast<int>(IntegrityVerdict::Ambiguous));
  EXPECT_EQ(static_cast<int>(record::Finding_MAX), static_cast<int>(Finding::Impossible));
  EXPECT_EQ(static_cast<int>(record::TrackMode_MAX), static_cast<int>(TrackMode::Slaved));
  EXPECT_EQ(static_cast<int>(record::FixType_MAX), static_cast<int>(FixType::Differential));
  EXPECT_EQ(static_cast<int>(record::MissionEventKind_MAX), static_cast<int>(MissionEventKind::Recycle));
  EXPECT_EQ(static_cast<int>(record::AntennaMode_MAX), static_cast<int>(AntennaMode::Autotrack));
  EXPECT_EQ(static_cast<int>(record::OperatorOrder_MAX), static_cast<int>(OperatorOrder::AcknowledgeAlarm));
}

TEST(ArchiveRecord, DoublesKeepEveryBit) {
  RadarTspi radar = some_radar(1);
  radar.measured.range_m = -0.0;
  radar.measured.azimuth_rad = std::bit_cast<double>(0x7FF8'0000'0000'1234ULL);  // a NaN with a payload
  radar.measured.elevation_rad = std::numeric_limits<double>::denorm_min();
  radar.snr_db = -std::numeric_limits<double>::infinity();
  record::RadarTspi message;
  to_proto(radar, message);
  record::RadarTspi parsed;
  ASSERT_TRUE(parsed.ParseFromString(message.SerializeAsString()));
  Defect defect;
  const RadarTspi back = from_proto(parsed, defect);
  const auto same = [](double a, double b) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(a), std::bit_cast<std::uint64_t>(b));
  };
  same(back.measured.range_m, radar.measured.range_m);
  same(back.measured.azimuth_rad, radar.measured.azimuth_rad);
  same(back.measured.elevation_rad, radar.measured.elevation_rad);
  same(back.snr_db, radar.snr_db);
}

TEST(ArchiveRecord, IllegalMessagesAreNamed) {
  const auto defect_of = [](const auto& message) {
    Defect defect;
    static_cast<void>(from_proto(message, defect));
    return defect.what;
  };
  record::RadarTspi radar;
  radar.set_mode(static_cast<record::TrackMode>(5));
  EXPECT_EQ(defect_of(radar), "mode: no enumerator has the number 5");
  radar.set_mode(static_cast<record::TrackMode>(-1));
  EXPECT_NE(defect_of(radar), "");
  radar.Clear();
  radar.set_sensor(std::string(32, 'x'));
  EXPECT_EQ(defect_of(radar), "sensor: longer than 31 characters or holding a NUL");
  radar.set_sensor(std::string("a\0b", 3));
  EXPECT_NE(defect_of(radar), "");

  record::GpsFix gps;
  gps.set_satellites(256);
  EXPECT_EQ(defect_of(gps), "satellites: above 255");

  record::Trajectory trajectory;
  to_proto(some_trajectory(), trajectory);
  trajectory.mutable_covariance()->RemoveLast();
  EXPECT_NE(defect_of(trajectory), "");
  trajectory.Clear();
  for (int i = 0; i < 10; ++i) trajectory.add_state(0);
  EXPECT_NE(defect_of(trajectory), "");

  record::SensorBias bias;
  to_proto(some_bias(), bias);
  bias.add_term(record::BIAS_TERM_TIME_TAG);
  EXPECT_NE(defect_of(bias), "");
  to_proto(some_bias(), bias);
  bias.set_term(0, static_cast<record::BiasTerm>(13));
  EXPECT_NE(defect_of(bias), "");

  record::SourceHealth health;
  for (std::size_t i = 0; i <= reason_count; ++i) health.add_count(1);
  EXPECT_NE(defect_of(health), "");
  health.Clear();
  health.set_why(static_cast<record::Disqualification>(5));
  EXPECT_EQ(defect_of(health), "why: no enumerator has the number 5");
}

TEST(ArchiveRecord, CountsOfReasonsByPairOrAsOlderArchivesHaveThem) {
  record::SourceHealth message;
  message.set_sensor("goheung");
  message.add_count(7);
  message.add_count(2);
  Defect defect;
  const SourceHealth older = from_proto(message, defect);
  EXPECT_EQ(defect.what, "");
  EXPECT_EQ(older.count[0], 7u);
  EXPECT_EQ(older.count[1], 2u);

  message.clear_count();
  for (const int reason : {3, 99}) {  // 99: of a newer program
    record::ReasonCount& counted = *message.add_counts();
    counted.set_reason(static_cast<record::Reason>(reason));
    counted.set_count(5);
  }
  const SourceHealth newer = from_proto(message, defect);
  EXPECT_EQ(defect.what, "");
  EXPECT_EQ(newer.count[3], 5u);
  EXPECT_EQ(std::accumulate(newer.count.begin(), newer.count.end(), std::uint64_t{0}), 5u);
}

TEST(ArchiveRecord, WrongCountsOfOurOwnDoNotReadPastTheArrays) {
  SensorBias bias = some_bias();
  bias.terms = 1000;
  record::SensorBias message;
  to_proto(bias, message);
  EXPECT_EQ(message.value_size(), max_bias_terms);
  bias.terms = -3;
  to_proto(bias, message);
  EXPECT_EQ(message.value_size(), 0);
}

// RFC 3629: a sensor's name in Latin-1 must not make the whole record unreadable; names in any script stay.
TEST(ArchiveRecord, NamesStayUtf8) {
  const auto written = [](std::string_view name) {
    RadarTspi radar = some_radar(1);
    radar.sensor = Name(name);
    record::RadarTspi message;
    to_proto(radar, message);
    record::RadarTspi parsed;
    EXPECT_TRUE(parsed.ParseFromString(message.SerializeAsString()));
    return parsed.sensor();
  };
  EXPECT_EQ(written("고흥 레이더"), "고흥 레이더");
  EXPECT_EQ(written("\xF0\x9F\x9A\x80"), "\xF0\x9F\x9A\x80");
  EXPECT_EQ(written("M\xFCnchen"), "M?nchen");
  EXPECT_EQ(written("\xC0\x80"), "??");            // overlong
  EXPECT_EQ(written("\xED\xA0\x80"), "???");       // surrogate
  EXPECT_EQ(written("\xF4\x90\x80\x80"), "????");  // above U+10FFFF
  EXPECT_EQ(written("end\xEA\xB3"), "end??");      // cut in the middle of a character
}

class ArchiveFile : public testing::TestWithParam<Compression> {};

TEST_P(ArchiveFile, HoldsEveryKindOfRecordInOrder) {
  const TemporaryFolder folder;
  const auto path = folder / "all.mcap";
  WriterOptions options;
  options.compression = GetParam();
  Writer writer(path, options);
  write_all_kinds(writer);
  const WriterStatus status = writer.close();
  EXPECT_TRUE(status.ok()) << status.failure;
  EXPECT_EQ(status.messages_written, all_kinds_count);
  EXPECT_EQ(status.bytes_written, std::filesystem::file_size(path));

  Reader reader(path);
  const std::vector<Entry> entries = read_all(reader);
  EXPECT_FALSE(reader.truncated());
  ASSERT_EQ(entries.size(), all_kinds_count);
  EXPECT_EQ(std::get<MissionEvent>(entries[0].record).label, Name("lift-off"));
  EXPECT_EQ(std::get<RadarTspi>(entries[1].record).measured.range_m, some_radar(1).measured.range_m);
  EXPECT_EQ(std::get<GpsFix>(entries[2].record).position.m, some_gps().position.m);
  EXPECT_EQ(std::get<Observation>(entries[3].record).step, 99u);
  EXPECT_EQ(std::get<Observation>(entries[4].record).verdict, Reason::Frozen);
  EXPECT_EQ(std::get<SensorBias>(entries[5].record).covariance, some_bias().covariance);
  EXPECT_EQ(std::get<Trajectory>(entries[6].record).state, some_trajectory().state);
  EXPECT_EQ(std::get<SlavingCommand>(entries[7].record).azimuth_rad, some_slaving().azimuth_rad);
  EXPECT_EQ(std::get<SourceHealth>(entries[8].record).count, some_health().count);
  EXPECT_EQ(std::get<Truth>(entries[9].record).acceleration_m_s2, some_truth().acceleration_m_s2);
  EXPECT_EQ(std::get<AngleTspi>(entries[10].record).azimuth_rad, some_angles().azimuth_rad);
  EXPECT_EQ(entries[10].role, Role::Input);
  EXPECT_EQ(entries[10].topic, "range/angles");
  EXPECT_EQ(entries[10].sequence, 5u);
  EXPECT_TRUE(std::get<OperatorCommand>(entries[11].record) == sample_at<OperatorCommand>(810));
  EXPECT_TRUE(std::get<AntennaReport>(entries[12].record) == sample_at<AntennaReport>(820));
  EXPECT_TRUE(std::get<PlatformState>(entries[13].record) == sample_at<PlatformState>(830));
  EXPECT_EQ(std::get<LastTick>(entries[14].record).tick, t0 + milliseconds(1000));

  // An observation consumed and an observation made are told apart; results carry the sequence of their event.
  EXPECT_EQ(entries[3].role, Role::Input);
  EXPECT_EQ(entries[4].role, Role::Output);
  EXPECT_EQ(entries[1].sequence, 2u);
  EXPECT_EQ(entries[7].sequence, 4u);

  ASSERT_EQ(reader.raw().attachments().size(), 1u);
  EXPECT_EQ(reader.raw().attachments()[0].name, "config.toml");
  EXPECT_EQ(reader.raw().attachments()[0].media_type, "application/toml");
  EXPECT_EQ(reader.raw().attachments()[0].data, "[range]\nname = \"naro\"\n");
  EXPECT_EQ(reader.raw().metadata().at("downrange").at("node"), "centre-a");
}

INSTANTIATE_TEST_SUITE_P(Compressions, ArchiveFile,
                         testing::Values(Compression::None, Compression::Zstd, Compression::Lz4));

}  // namespace
}  // namespace downrange::archive
