/// Two nodes command two antennas. The stronger one has nothing more to say of one of them: that antenna hears the
/// weaker node, whoever made its DDS, while the other antenna hears the stronger one. Domains 42 and 43.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <thread>

#include "child_process.hpp"
#include "dds/outputs.hpp"
#include "dds_inbox.hpp"
#include "dds_samples.hpp"
#include "patient_profiles.hpp"

namespace downrange::dds {
namespace {

/// The commands of both nodes, tick by tick: the tick's number as apply_at, the node's name as target.
class TwoNodes {
 public:
  explicit TwoNodes(int domain)
      : strong_participant_({domain, profiles_.path, "strong", ClockMode::Wall}),
        weak_participant_({domain, profiles_.path, "weak", ClockMode::Wall}),
        strong_(strong_participant_, options(20)),
        weak_(weak_participant_, options(10)) {}

  [[nodiscard]] const std::filesystem::path& profiles() const { return profiles_.path; }
  void next_tick() {
    ++tick_;
    if (!lost_at_) command(strong_, "strong", "lost");
    command(strong_, "strong", "kept");
    for (const char* antenna : {"lost", "kept"}) command(weak_, "weak", antenna);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  /// The stronger node has nothing to say of one antenna from the next tick on.
  void lose() { lost_at_ = tick_ + 1; }
  [[nodiscard]] std::int64_t lost_at() const { return lost_at_.value_or(0); }

 private:
  static OutputOptions options(int strength) {
    OutputOptions options;
    options.strength = strength;
    options.owned_keys<SlavingCommand>() = {{"lost", {}}, {"kept", {}}};
    return options;
  }
  [[nodiscard]] Time now() const { return Time{1'800'000'000'000'000'000} + milliseconds(25 * tick_); }
  void command(OutputWriters& node, const char* name, const char* antenna) const {
    SlavingCommand command = sample_command(antenna);
    command.target = name;
    command.tick = now();
    command.apply_at.ns = tick_;
    node.emit(command);
  }

  PatientProfiles profiles_;
  Participant strong_participant_;
  Participant weak_participant_;
  OutputWriters strong_;
  OutputWriters weak_;
  std::int64_t tick_ = 0;
  std::optional<std::int64_t> lost_at_;
};

/// Who commanded an antenna at which tick, as the antenna heard it.
struct Heard {
  Name node;
  std::int64_t tick = 0;
};

class Antenna {
 public:
  void hear(const Heard& command) { heard_.add(command); }
  /// From that tick on.
  [[nodiscard]] std::vector<Heard> heard(std::int64_t since = 0) const {
    std::vector<Heard> commands = heard_.items();
    std::erase_if(commands, [&](const Heard& c) { return c.tick < since; });
    return commands;
  }
  /// While the nodes and the antenna are meeting, commands of both may come.
  [[nodiscard]] bool settled_on(const Name& node) const {
    const std::vector<Heard> all = heard();
    return all.size() >= settled &&
           std::all_of(all.end() - settled, all.end(), [&](const Heard& h) { return h.node == node; });
  }
  static constexpr std::ptrdiff_t settled = 20;

 private:
  Inbox<Heard> heard_;
};

/// Flies until both antennas have heard the stronger node, loses one, flies until that one hears the weaker node.
void fly(TwoNodes& nodes, const Antenna& lost, const Antenna& kept) {
  const auto fly_until = [&](const auto& condition) {
    for (int i = 0; i < 3000 && !condition(); ++i) nodes.next_tick();
    ASSERT_TRUE(condition());
  };
  fly_until([&] { return lost.settled_on("strong") && kept.settled_on("strong"); });
  nodes.lose();
  fly_until([&] { return lost.settled_on("weak"); });
}

void expect_change_over(const TwoNodes& nodes, const Antenna& antenna) {
  const std::vector<Heard> heard = antenna.heard(nodes.lost_at() - Antenna::settled / 2);
  const auto weak = std::ranges::find(heard, Name("weak"), &Heard::node);
  ASSERT_NE(weak, heard.begin());
  ASSERT_NE(weak, heard.end());
  EXPECT_EQ((weak - 1)->tick, nodes.lost_at() - 1) << "the stronger one's last";
  EXPECT_GE(weak->tick, nodes.lost_at());
  EXPECT_TRUE(std::all_of(weak, heard.end(), [](const Heard& h) { return h.node == Name("weak"); }));
}

TEST(DdsRelease, AFastDdsAntennaHearsTheWeakerNodeWhereTheStrongerIsSilent) {
  TwoNodes nodes(42);
  Participant consumer({42, nodes.profiles(), "antennas", ClockMode::Wall});
  Antenna lost;
  Antenna kept;
  const OutputReaders readers(consumer, {},
                              {[&](const Result& result) {
                                 if (const auto* c = std::get_if<SlavingCommand>(&result))
                                   (c->antenna == Name("lost") ? lost : kept).hear({c->target, c->apply_at.ns});
                               },
                               {}});
  fly(nodes, lost, kept);
  expect_change_over(nodes, lost);
  for (const Heard& heard : kept.heard(nodes.lost_at())) EXPECT_EQ(heard.node, Name("strong"));
}

#ifdef CYCLONE_CLIENT
/// A client of another vendor's, listened to on a thread of its own.
class CycloneAntenna : public Antenna {
 public:
  explicit CycloneAntenna(const char* name)
      : client_({CYCLONE_CLIENT, "43", name, "1000000", "100", "3000"},
                {"CYCLONEDDS_URI=<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers>"
                 "<Peer address=\"127.0.0.1\"/></Peers></Discovery>"}),
        listening_([this] {
          // "VERDICT TARGET azimuth_rad ... apply_at_ns TICK"
          while (const auto line = client_.line()) {
            const std::size_t name_at = line->find(' ') + 1;
            hear({Name(line->substr(name_at, line->find(' ', name_at) - name_at).c_str()),
                  std::strtoll(line->c_str() + line->rfind(' '), nullptr, 10)});
          }
        }) {}
  ~CycloneAntenna() {
    client_.kill();
    listening_.join();
  }
  CycloneAntenna(const CycloneAntenna&) = delete;
  CycloneAntenna& operator=(const CycloneAntenna&) = delete;

 private:
  ChildProcess client_;
  std::thread listening_;
};

TEST(DdsRelease, AnotherVendorsAntennaHearsTheWeakerNodeWhereTheStrongerIsSilent) {
  TwoNodes nodes(43);
  const CycloneAntenna lost("lost");
  const CycloneAntenna kept("kept");
  fly(nodes, lost, kept);
  expect_change_over(nodes, lost);
  for (const Heard& heard : kept.heard(nodes.lost_at())) EXPECT_EQ(heard.node, Name("strong"));
}
#endif

}  // namespace
}  // namespace downrange::dds
