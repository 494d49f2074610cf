#include "server/cluster/failure_detector.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/cluster/timing.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

using Ids = std::vector<std::string>;

NodeReport Report(const std::string& node_id, int64_t incarnation = 1,
                  std::vector<NodeLoss> losses = {}) {
  NodeReport report;
  report.status.node_id = node_id;
  report.incarnation = incarnation;
  report.losses = std::move(losses);
  return report;
}

// The detector of a node, with the time and the network that the test gives it.
class FailureDetectorTest : public testing::Test {
 protected:
  bool Update(const Ids& heard = {}, bool sends_heartbeats = true) {
    return detector_.Update(now_, reports_, heard, sends_heartbeats);
  }
  // Updates at the usual interval. Returns whether there was something to publish.
  bool UpdateFor(absl::Duration duration, const Ids& heard = {}) {
    bool is_news = false;
    for (const absl::Time end = now_ + duration; now_ < end;) {
      now_ += kRefreshInterval;
      is_news = Update(heard) || is_news;
    }
    return is_news;
  }
  Ids Others() const {
    Ids ids;
    for (const NodeStatus& status : detector_.others()) {
      ids.push_back(status.node_id);
    }
    return ids;
  }

  const absl::Duration soon_ = kFirstHeartbeatTimeout + kNodeLease + 2 * kRefreshInterval;

  absl::Time now_ = absl::UnixEpoch();
  std::vector<NodeReport> reports_ = {Report("c")};  // the local node reads its own, too
  FailureDetector detector_{"c"};
};

TEST_F(FailureDetectorTest, MonitorsTheThreeNodesBeforeItInACircle) {
  Update();
  EXPECT_THAT(detector_.monitored(), IsEmpty());
  reports_ = {Report("a"), Report("b"), Report("c")};
  Update();
  EXPECT_THAT(detector_.monitored(), ElementsAre("b", "a"));
  reports_ = {Report("x"), Report("a"), Report("d"), Report("c"), Report("b")};
  Update();
  EXPECT_THAT(detector_.monitored(), ElementsAre("b", "a"));  // not twice in a moment
  UpdateFor(kMonitorIntervalMin);
  EXPECT_THAT(detector_.monitored(), ElementsAre("b", "a", "x"));
}

TEST_F(FailureDetectorTest, NodeWithoutHeartbeatsIsLostAfterTheLease) {
  reports_ = {Report("a"), Report("b", 7), Report("c")};
  EXPECT_FALSE(UpdateFor(absl::Minutes(1), {"a", "b"}));
  EXPECT_FALSE(UpdateFor(kNodeLease - kRefreshInterval, {"a"}));
  EXPECT_THAT(Others(), UnorderedElementsAre("a", "b"));
  EXPECT_TRUE(UpdateFor(2 * kRefreshInterval, {"a"}));
  EXPECT_THAT(Others(), ElementsAre("a"));
  EXPECT_THAT(detector_.losses(), ElementsAre(NodeLoss{"b", 7}));
}

TEST_F(FailureDetectorTest, LostNodeThatIsHeardAgainReturns) {
  reports_ = {Report("a"), Report("b"), Report("c"), Report("x"), Report("y"), Report("z")};
  UpdateFor(soon_, {"a", "z"});
  EXPECT_THAT(Others(), UnorderedElementsAre("a", "x", "y", "z"));
  EXPECT_THAT(detector_.monitored(), ElementsAre("a", "z", "y", "b"));
  EXPECT_TRUE(UpdateFor(kRefreshInterval, {"b"}));
  EXPECT_THAT(detector_.losses(), IsEmpty());
  EXPECT_THAT(Others(), UnorderedElementsAre("a", "b", "x", "y", "z"));
}

TEST_F(FailureDetectorTest, NodeThatNeverSentAHeartbeatIsLost) {
  reports_ = {Report("b"), Report("c")};
  EXPECT_FALSE(UpdateFor(kFirstHeartbeatTimeout));
  EXPECT_THAT(Others(), ElementsAre("b"));
  EXPECT_TRUE(UpdateFor(soon_));
  EXPECT_THAT(Others(), IsEmpty());
}

TEST_F(FailureDetectorTest, LossReportedByAnyNodeHoldsUntilItIsRefuted) {
  reports_ = {Report("a", 1, {{"b", 4}}), Report("b", 4), Report("c")};
  EXPECT_FALSE(UpdateFor(kRefreshInterval));
  EXPECT_THAT(Others(), ElementsAre("a"));
  reports_[1].incarnation = 5;
  EXPECT_FALSE(UpdateFor(kRefreshInterval));
  EXPECT_THAT(Others(), UnorderedElementsAre("a", "b"));
}

TEST_F(FailureDetectorTest, LossesOfALostNodeDoNotCount) {
  reports_ = {Report("a", 1, {{"b", 1}, {"d", 1}}), Report("b"), Report("c"),
              Report("d", 2, {{"a", 1}})};
  Update();
  EXPECT_THAT(Others(), UnorderedElementsAre("b", "d"));
  reports_[0].incarnation = 2;  // it refutes
  Update();
  EXPECT_THAT(Others(), UnorderedElementsAre("a", "d"));
}

TEST_F(FailureDetectorTest, NodeThatWasCutOffForgetsItsLosses) {
  reports_ = {Report("a"), Report("b"), Report("c")};
  UpdateFor(soon_);
  EXPECT_THAT(Others(), IsEmpty());
  reports_[0].losses = {{"c", 1}};
  EXPECT_TRUE(Update());
  EXPECT_EQ(detector_.incarnation(), 2);
  EXPECT_THAT(detector_.losses(), IsEmpty());
  EXPECT_FALSE(UpdateFor(kFirstHeartbeatTimeout));
  EXPECT_THAT(Others(), UnorderedElementsAre("a", "b"));
}

TEST_F(FailureDetectorTest, NodeRefutesItsLossWhileItSendsHeartbeats) {
  reports_ = {Report("a", 1, {{"c", 1}}), Report("b", 1, {{"c", 8}}), Report("c")};
  EXPECT_FALSE(Update({}, /*sends_heartbeats=*/false));
  EXPECT_EQ(detector_.incarnation(), 1);
  EXPECT_TRUE(Update());
  EXPECT_EQ(detector_.incarnation(), 9);
  EXPECT_FALSE(Update());
  EXPECT_THAT(Others(), UnorderedElementsAre("a", "b"));
}

TEST_F(FailureDetectorTest, NodeThatSendsNoHeartbeatsMonitorsNone) {
  reports_ = {Report("b"), Report("c")};
  EXPECT_FALSE(Update());
  EXPECT_THAT(detector_.monitored(), ElementsAre("b"));
  EXPECT_FALSE(Update({}, /*sends_heartbeats=*/false));
  EXPECT_THAT(detector_.monitored(), IsEmpty());
}

TEST_F(FailureDetectorTest, ProcessThatWasStoppedLosesNoNode) {
  reports_ = {Report("b"), Report("c")};
  UpdateFor(absl::Seconds(10), {"b"});
  now_ += absl::Hours(1);
  EXPECT_FALSE(Update());
  EXPECT_FALSE(UpdateFor(absl::Seconds(1)));
  EXPECT_THAT(Others(), ElementsAre("b"));
}

TEST_F(FailureDetectorTest, LossesOfNodesThatLeftOrReturnedAreDropped) {
  reports_ = {Report("a"), Report("b"), Report("c")};
  EXPECT_TRUE(UpdateFor(soon_));
  EXPECT_FALSE(UpdateFor(absl::Minutes(1)));
  EXPECT_THAT(detector_.losses(), UnorderedElementsAre(NodeLoss{"a", 1}, NodeLoss{"b", 1}));
  reports_ = {Report("b", 2), Report("c")};
  EXPECT_TRUE(Update());
  EXPECT_THAT(detector_.losses(), IsEmpty());
  EXPECT_THAT(Others(), ElementsAre("b"));
}

TEST_F(FailureDetectorTest, LossesAreBounded) {
  for (int i = 0; i < 2 * kLossesMax; ++i) {
    reports_.push_back(Report(absl::StrCat("forged-", i)));
  }
  UpdateFor((2 * kLossesMax / kMonitorsOfNode + 1) * soon_);
  EXPECT_EQ(detector_.losses().size(), kLossesMax);
}

}  // namespace
}  // namespace procgen
