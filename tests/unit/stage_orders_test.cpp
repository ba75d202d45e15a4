/// What operators may order, what of it is in force, and that ingest obeys.
#include <gtest/gtest.h>

#include <limits>

#include "../support/small_range.hpp"
#include "stage/ingest.hpp"
#include "stage/orders.hpp"

namespace downrange {
namespace {

using test::liftoff;
using test::small_range;

/// Sources of small_range by SourceId.
constexpr SourceId goheung = 0;
constexpr SourceId jeju = 1;

OperatorCommand order(OperatorOrder what, const Name& subject, double t, const Name& argument = {}) {
  OperatorCommand command;
  command.operator_id = "kim";
  command.order = what;
  command.subject = subject;
  command.argument = argument;
  command.reason = "as agreed with flight safety";
  command.epoch = liftoff + seconds(t);
  command.received = command.epoch;
  command.simulated = true;
  return command;
}

TEST(Orders, NobodyOrderedAnything) {
  const Orders orders(small_range());
  EXPECT_FALSE(orders.inhibited(goheung) || orders.forced(goheung));
  EXPECT_EQ(orders.of(goheung), nullptr);
  EXPECT_TRUE(orders.held_chain(0).empty());
}

TEST(Orders, TheNewestOrderOnASourceHolds) {
  Orders orders(small_range());
  orders.note(order(OperatorOrder::Inhibit, "goheung", 10));
  EXPECT_TRUE(orders.inhibited(goheung));
  EXPECT_FALSE(orders.inhibited(jeju)) << "another's";
  ASSERT_NE(orders.of(goheung), nullptr);
  EXPECT_EQ(orders.of(goheung)->by, Name("kim"));
  EXPECT_EQ(orders.of(goheung)->reason, Remark("as agreed with flight safety"));
  EXPECT_EQ(orders.of(goheung)->since, liftoff + seconds(10));
  orders.note(order(OperatorOrder::Force, "goheung", 11));
  EXPECT_TRUE(orders.forced(goheung) && !orders.inhibited(goheung));
  orders.note(order(OperatorOrder::Release, "goheung", 12));
  EXPECT_EQ(orders.of(goheung), nullptr);
}

TEST(Orders, HistoryThatIsToldAgainChangesNothing) {
  Orders orders(small_range());
  orders.note(order(OperatorOrder::Inhibit, "goheung", 10));
  orders.note(order(OperatorOrder::Release, "goheung", 12));
  OperatorCommand again = order(OperatorOrder::Inhibit, "goheung", 10);
  again.received = liftoff + seconds(20);
  orders.note(again);
  EXPECT_FALSE(orders.inhibited(goheung));
}

TEST(Orders, ATargetIsHeldOnAChainUntilReleased) {
  Orders orders(small_range());
  for (const char* chain : {"all", "without-jeju", "only-goheung", "without-GPS", "only-GPS"}) {
    orders.note(order(OperatorOrder::HoldChain, "kslv", 1, chain));
    EXPECT_EQ(orders.held_chain(0), Name(chain));
  }
  for (const char* chain :
       {"", "without-nobody", "joint", "only-", "only-goheung-tgs", "without-radars", "only-radars"}) {
    const OperatorCommand bad = order(OperatorOrder::HoldChain, "kslv", 2, chain);
    EXPECT_NE(
        orders.refusal(bad).find("no chain is named '" + std::string(chain) + "': there are all, without-goheung"),
        std::string::npos)
        << orders.refusal(bad);
    orders.note(bad);
    EXPECT_EQ(orders.held_chain(0), Name("only-GPS")) << chain;
  }
  orders.note(order(OperatorOrder::Release, "kslv", 3));
  EXPECT_TRUE(orders.held_chain(0).empty());
  EXPECT_EQ(orders.hold_of(0), nullptr);
}

TEST(Orders, AnAntennaIsPinnedTrimmedAndStoppedUntilReleased) {
  Orders orders(small_range());
  constexpr int antenna = 0;
  const auto stands = [](const StandingOrder& order) { return order.order != OperatorOrder::Release; };
  orders.note(order(OperatorOrder::PinAntennaSource, "goheung-tm", 1, "only-goheung"));
  orders.note(order(OperatorOrder::PinAntennaTarget, "goheung-tm", 2, "kslv"));
  OperatorCommand trim = order(OperatorOrder::TrimAntenna, "goheung-tm", 3);
  trim.azimuth_trim_rad = 0.5 * test::deg;
  trim.elevation_trim_rad = -5 * test::deg;
  orders.note(trim);
  EXPECT_FALSE(stands(orders.of_antenna(antenna).stop));
  orders.note(order(OperatorOrder::StopAntenna, "goheung-tm", 4));
  const AntennaOrders of = orders.of_antenna(antenna);
  EXPECT_EQ(of.source.argument, Name("only-goheung"));
  EXPECT_EQ(of.target.argument, Name("kslv"));
  EXPECT_EQ(of.trim.azimuth_trim_rad, 0.5 * test::deg);
  EXPECT_EQ(of.trim.elevation_trim_rad, -5 * test::deg);
  EXPECT_EQ(of.stop.by, Name("kim"));
  orders.note(order(OperatorOrder::Release, "goheung-tm", 3.5));
  EXPECT_TRUE(stands(orders.of_antenna(antenna).stop)) << "given before the stop";
  EXPECT_FALSE(stands(orders.of_antenna(antenna).trim)) << "after the trim";
  orders.note(order(OperatorOrder::Release, "goheung-tm", 5));
  for (const StandingOrder& each : {orders.of_antenna(antenna).source, orders.of_antenna(antenna).target,
                                    orders.of_antenna(antenna).trim, orders.of_antenna(antenna).stop})
    EXPECT_FALSE(stands(each));
}

TEST(Orders, WhatCannotBeDoneIsRefusedWithItsReason) {
  const Orders orders(small_range());
  const auto refused = [&](OperatorCommand command) { return orders.refusal(command); };
  EXPECT_EQ(refused(order(OperatorOrder::Inhibit, "goheung", 1)), "");
  EXPECT_EQ(refused(order(OperatorOrder::Inhibit, "gohung", 1)),
            "no source is named 'gohung': there are goheung, jeju, goheung-tgs, jeju-tgs");
  EXPECT_EQ(refused(order(OperatorOrder::HoldChain, "goheung", 1, "all")),
            "no target is named 'goheung': there are kslv");
  EXPECT_EQ(refused(order(OperatorOrder::Release, "nobody", 1)),
            "neither a source, a target nor an antenna is named 'nobody'");
  EXPECT_EQ(refused(order(OperatorOrder::ResetBias, "goheung-tgs", 1)),
            "'goheung-tgs' relays a receiver: no bias of it is estimated");
  EXPECT_EQ(refused(order(OperatorOrder::StopAntenna, "goheung", 1)),
            "no antenna is named 'goheung': there are goheung-tm, jeju-tm");
  EXPECT_EQ(refused(order(OperatorOrder::PinAntennaTarget, "goheung-tm", 1, "spent-stage")),
            "no target is named 'spent-stage': there are kslv");
  EXPECT_NE(refused(order(OperatorOrder::PinAntennaSource, "goheung-tm", 1, "nobody")).find("no chain is named"),
            std::string::npos);
  for (const double trim_deg : {5.1, -6.0, std::numeric_limits<double>::quiet_NaN()}) {
    for (const bool elevation : {false, true}) {
      OperatorCommand trim = order(OperatorOrder::TrimAntenna, "goheung-tm", 1);
      (elevation ? trim.elevation_trim_rad : trim.azimuth_trim_rad) = trim_deg * test::deg;
      EXPECT_EQ(refused(trim), "a trim is at most 5 deg either way") << trim_deg;
    }
  }
  OperatorCommand command = order(OperatorOrder::Inhibit, "goheung", 1);
  command.operator_id = {};
  EXPECT_EQ(refused(command), "it does not say who orders");
  command = order(OperatorOrder::Inhibit, "goheung", 1);
  command.reason = {};
  EXPECT_EQ(refused(command), "it gives no reason");
  command = order(OperatorOrder::Inhibit, "goheung", 1);
  command.simulated = false;
  EXPECT_EQ(refused(command),
            "this node flies a simulated flight and takes its orders only (ingest.expect_simulated = true)");
  command = order(OperatorOrder::Inhibit, "goheung", 1);
  command.received = command.epoch - milliseconds(101);
  EXPECT_NE(refused(command).find("dated in the future"), std::string::npos);
}

TEST(Orders, AnOrderGivenBeforeTheOneInForceIsRefused) {
  Orders orders(small_range());
  orders.note(order(OperatorOrder::Release, "goheung-tm", 1.2));
  const OperatorCommand stop = order(OperatorOrder::StopAntenna, "goheung-tm", 0.2);
  EXPECT_EQ(orders.refusal(stop),
            "it was given 1.0 s before the order of 'kim' that is in force, or one of the clocks is wrong");
  orders.note(stop);
  EXPECT_TRUE(words_of(orders.of_antenna(0)).empty());
  EXPECT_EQ(orders.refusal(order(OperatorOrder::StopAntenna, "jeju-tm", 0.2)), "") << "another antenna";
  EXPECT_EQ(orders.refusal(order(OperatorOrder::StopAntenna, "goheung-tm", 1.2)), "") << "at once";
  orders.note(order(OperatorOrder::StopAntenna, "goheung-tm", 2));
  orders.note(order(OperatorOrder::TrimAntenna, "goheung-tm", 3));
  EXPECT_EQ(orders.refusal(order(OperatorOrder::Release, "goheung-tm", 2.5)), "") << "it ends the stop";
  EXPECT_NE(orders.refusal(order(OperatorOrder::Release, "goheung-tm", 0.5)), "");
}

TEST(Orders, OfAChainThatIsNotRunNoneIsTaken) {
  RangeConfig range = small_range();
  range.integrity.enabled = false;
  const Orders orders(range);
  EXPECT_EQ(orders.refusal(order(OperatorOrder::PinAntennaSource, "goheung-tm", 1, "only-goheung")),
            "there is no chain but all: INTEGRITY is off, or one source is alone");
  EXPECT_EQ(orders.refusal(order(OperatorOrder::PinAntennaSource, "goheung-tm", 1, "all")), "");
}

TEST(Orders, WhatStandsOfAnAntennaInWords) {
  Orders orders(small_range());
  EXPECT_TRUE(words_of(orders.of_antenna(0)).empty());
  OperatorCommand trim = order(OperatorOrder::TrimAntenna, "goheung-tm", 1);
  trim.azimuth_trim_rad = 0.25 * test::deg;
  orders.note(trim);
  orders.note(order(OperatorOrder::StopAntenna, "goheung-tm", 2));
  const std::string why = std::string(trim.reason.view());
  EXPECT_EQ(words_of(orders.of_antenna(0)).view(),
            "stopped by kim (" + why + "); trimmed by 0.250, 0.000 deg by kim (" + why + ")");
  OperatorCommand pin = order(OperatorOrder::PinAntennaSource, "goheung-tm", 3, "only-goheung");
  pin.reason = Remark(std::string(Remark::max_size, 'x'));
  orders.note(pin);
  EXPECT_EQ(words_of(orders.of_antenna(0)).view().size(), Remark::max_size) << "cut";
}

TEST(Orders, ARefusalNamesAsManyAsItHasRoomFor) {
  RangeConfig range = small_range();
  for (int i = 0; i < 40; ++i) range.targets.push_back({.id = Name("object-" + std::to_string(i))});
  const std::string refusal = Orders(range).refusal(order(OperatorOrder::PinAntennaTarget, "goheung-tm", 1, "x"));
  EXPECT_LT(refusal.size(), Remark::max_size) << refusal;
  EXPECT_NE(refusal.find(" more"), std::string::npos) << refusal;
}

TEST(Ingest, AnInhibitedSourceIsRejectedUntilItIsReleased) {
  const RangeConfig range = small_range();
  Ingest ingest(range);
  const auto judge = [&](std::size_t radar, double t) {
    return ingest.judge(test::plot_at(range.radars[radar], t, static_cast<std::uint64_t>(100 * t))).verdict;
  };
  EXPECT_EQ(judge(0, 30), Reason::Accepted);
  ingest.note(order(OperatorOrder::Inhibit, "goheung", 30.1));
  EXPECT_EQ(judge(0, 30.2), Reason::Inhibited);
  EXPECT_EQ(judge(1, 30.2), Reason::Accepted) << "another source";
  ingest.note(order(OperatorOrder::Force, "goheung", 30.3));
  EXPECT_EQ(judge(0, 30.4), Reason::Accepted) << "forced: used";
  ingest.note(order(OperatorOrder::Inhibit, "goheung", 30.5));
  ingest.note(order(OperatorOrder::Release, "goheung", 30.6));
  EXPECT_EQ(judge(0, 30.7), Reason::Accepted);
}

TEST(Ingest, TheFixOfAnInhibitedStationIsTakenFromAnother) {
  const RangeConfig range = small_range();
  Ingest ingest(range);
  ingest.note(order(OperatorOrder::Inhibit, "goheung-tgs", 29));
  EXPECT_EQ(ingest.judge(test::fix_at("goheung-tgs", 30, 1)).verdict, Reason::Inhibited);
  EXPECT_EQ(ingest.judge(test::fix_at("jeju-tgs", 30, 1, 0.6)).verdict, Reason::Accepted) << "no duplicate";
}

TEST(Ingest, ACentreInhibitsWhatItsIngestNodesAccepted) {
  const RangeConfig range = small_range();
  const Observation accepted = Ingest(range).judge(test::plot_at(range.radars[0], 30, 1));
  Ingest centre(range);
  centre.note(order(OperatorOrder::Inhibit, "goheung", 29));
  EXPECT_EQ(centre.judge(accepted).verdict, Reason::Inhibited);
}

}  // namespace
}  // namespace downrange
