// Whose acknowledgement counts for an order.

#include <gtest/gtest.h>

#include "app/downrange/node_answers.hpp"

namespace downrange::app {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t topic = 4;

dds::ServiceStatus status(const Name& node, std::vector<dds::Acknowledgement> acknowledgements = {}) {
  dds::ServiceStatus s;
  s.node = node;
  s.acknowledgements = std::move(acknowledgements);
  return s;
}

TEST(NodeAnswersTest, EveryNodeHeardMustAnswer) {
  NodeAnswers answers(topic, "kim", 7);
  EXPECT_FALSE(answers.wait_for_nodes(milliseconds(1)));
  EXPECT_FALSE(answers.all_in_force()) << "nobody heard it";
  answers.add(status("centre"));
  answers.add(status("site"));
  EXPECT_TRUE(answers.wait_for_nodes(milliseconds(1)));
  answers.add(status("centre", {{topic, "kim", 7, ""}}));
  EXPECT_FALSE(answers.wait_for_all(milliseconds(1)));
  EXPECT_EQ(answers.text(), "node centre: in force\nnode site: NO ANSWER\n");
  answers.add(status("site", {{topic, "kim", 8, ""}, {topic, "kim", 7, ""}}));
  EXPECT_TRUE(answers.wait_for_all(milliseconds(1)));
  EXPECT_TRUE(answers.all_in_force());
}

TEST(NodeAnswersTest, AnotherOrdersAnswerIsNone) {
  NodeAnswers answers(topic, "kim", 7);
  answers.add(status("centre", {{topic, "kim", 6, ""}, {topic, "lee", 7, ""}, {topic + 1, "kim", 7, ""}}));
  EXPECT_FALSE(answers.wait_for_all(milliseconds(1)));
}

TEST(NodeAnswersTest, ARefusalIsToldAndIsNotInForce) {
  NodeAnswers answers(topic, "kim", 7);
  answers.add(status("centre", {{topic, "kim", 7, "no source is named 'x'"}}));
  EXPECT_TRUE(answers.wait_for_all(milliseconds(1)));
  EXPECT_FALSE(answers.all_in_force());
  EXPECT_EQ(answers.text(), "node centre: REFUSED: no source is named 'x'\n");
}

TEST(NodeAnswersTest, AnOrderOnAnAntennaIsAMatterOfTheNodesThatPointOne) {
  dds::ServiceStatus site = status("site", {{topic, "kim", 7, ""}});
  site.stages = {.align = false, .fuse = false, .slave = false};
  NodeAnswers alone(topic, "kim", 7, true);
  alone.add(site);
  EXPECT_TRUE(alone.wait_for_all(milliseconds(1)));
  EXPECT_FALSE(alone.all_in_force());
  EXPECT_EQ(alone.text(), "node site: points no antennas\n");
  NodeAnswers both(topic, "kim", 7, true);
  both.add(site);
  both.add(status("centre", {{topic, "kim", 7, ""}}));
  EXPECT_TRUE(both.all_in_force());
  NodeAnswers of_source(topic, "kim", 7);
  of_source.add(site);
  EXPECT_TRUE(of_source.all_in_force());
}

TEST(NodeAnswersTest, ANodeThatStoppedOwesNoAnswer) {
  NodeAnswers answers(topic, "kim", 7);
  answers.add(status("centre", {{topic, "kim", 7, ""}}));
  answers.add(status("site"));
  dds::ServiceStatus stopped = status("site");
  stopped.state = "stopped";
  answers.add(stopped);
  EXPECT_TRUE(answers.all_in_force());
}

}  // namespace
}  // namespace downrange::app
