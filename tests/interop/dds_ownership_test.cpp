/// Two nodes command one antenna: the stronger one's commands count while it lives. Domain 41.

#include <gtest/gtest.h>

#include "child_process.hpp"
#include "dds/outputs.hpp"
#include "dds_inbox.hpp"
#include "dds_samples.hpp"
#include "patient_profiles.hpp"

namespace downrange::dds {
namespace {

constexpr int domain = 41;

ChildProcess start_node(const PatientProfiles& profiles, const char* name, int strength) {
  return ChildProcess({OWNER_NODE, std::to_string(domain), profiles.path.string(), name, std::to_string(strength)});
}

TEST(DdsOwnership, TheWeakerNodeTakesOverWhenTheStrongerOneDies) {
  const PatientProfiles profiles;
  Participant consumer({domain, profiles.path, "antenna", ClockMode::Wall});
  Inbox<Name> targets;
  OutputReaders readers(consumer, {},
                        {[&](const Result& result) {
                           if (const auto* command = std::get_if<SlavingCommand>(&result)) {
                             targets.add(command->target);
                           }
                         },
                         {}});
  const auto seen_last = [](const Name& node) {
    return [node](const std::vector<Name>& seen) { return !seen.empty() && seen.back() == node; };
  };
  ChildProcess weak = start_node(profiles, "weak", 10);
  ASSERT_TRUE(targets.wait(seen_last("weak")));
  {
    ChildProcess strong = start_node(profiles, "strong", 20);
    ASSERT_TRUE(targets.wait(seen_last("strong")));
    ASSERT_TRUE(targets.wait_for_size(targets.items().size() + 50));
    strong.kill();
  }
  ASSERT_TRUE(targets.wait(seen_last("weak")));
  ASSERT_TRUE(targets.wait_for_size(targets.items().size() + 50));

  // weak..., strong..., weak...: one hand-over each way, nothing mixed.
  const std::vector<Name> seen = targets.items();
  std::vector<Name> owners;
  for (const Name& target : seen) {
    if (owners.empty() || owners.back() != target) owners.push_back(target);
  }
  EXPECT_EQ(owners, (std::vector<Name>{"weak", "strong", "weak"}));
}

}  // namespace
}  // namespace downrange::dds
