#include "clients/top/screen.h"

#include <string>
#include <vector>

#include "absl/time/time.h"
#include "clients/top/terminal.h"
#include "clients/top/text_table.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen_top {
namespace {

namespace v1 = procgen::v1;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

v1::Pool PoolOf(const std::string& name, const std::string& owner,
                const std::vector<std::string>& games, int64_t step_count) {
  v1::Pool pool;
  pool.set_name(name);
  pool.set_owner(owner);
  pool.mutable_spec()->mutable_games()->Assign(games.begin(), games.end());
  pool.mutable_spec()->set_env_count(64);
  pool.set_step_count(step_count);
  return pool;
}

void FillLatencyHistogram(const std::vector<int64_t>& counts, double sum,
                          v1::LatencyHistogram* latency) {
  for (const double bound : {1e-5, 1e-3, 1.0}) {
    latency->add_bounds_seconds(bound);
  }
  latency->mutable_counts()->Assign(counts.begin(), counts.end());
  latency->set_sum_seconds(sum);
}

Sample Before() {
  Sample sample;
  sample.time = absl::FromUnixSeconds(1000);
  sample.load.set_step_count(10000);
  sample.load.set_stream_received_bytes(100);
  sample.load.set_stream_sent_bytes(5000);
  FillLatencyHistogram({100, 0, 0, 0}, 1e-4, sample.load.mutable_queue_wait());
  FillLatencyHistogram({0, 100, 0, 0}, 0.05, sample.load.mutable_execution_time());
  sample.pools = {PoolOf("pools/1", "", {"maze"}, 4000), PoolOf("pools/2", "", {"maze"}, 6000)};
  return sample;
}

// Two seconds later: pool 2 took 1280 steps in 20 requests, pool 3 is new.
Sample Now() {
  Sample sample = Before();
  sample.time += absl::Seconds(2);
  sample.load.set_pool_count(3);
  sample.load.set_env_count(192);
  sample.load.set_stream_count(1);
  sample.load.set_worker_count(2);
  sample.load.set_resume_buffer_bytes(12'300'000);
  sample.load.set_step_count(11280);
  sample.load.set_stream_received_bytes(2100);
  sample.load.set_stream_sent_bytes(3'005'000);
  sample.load.clear_queue_wait();
  FillLatencyHistogram({119, 0, 1, 0}, 0.4001, sample.load.mutable_queue_wait());
  sample.load.clear_execution_time();
  FillLatencyHistogram({0, 120, 0, 0}, 0.06, sample.load.mutable_execution_time());
  sample.pools[0].mutable_expire_time()->set_seconds(1032);
  sample.pools[1].set_step_count(7280);
  sample.pools[1].set_attached(true);
  sample.pools[1].set_episode_count(12);
  sample.pools[1].set_mean_episode_return(3.5F);
  sample.pools[1].set_mean_episode_length(120);
  sample.pools[1].mutable_request_duration_p50()->set_nanos(1'500'000);
  sample.pools[1].mutable_create_time()->set_seconds(702);
  sample.pools[1].mutable_spec()->mutable_options()->set_distribution_mode(
      v1::DISTRIBUTION_MODE_HARD);
  sample.pools.push_back(PoolOf("pools/3", "alice", {"a", "b", "c", "d", "e"}, 0));
  return sample;
}

// The lines of a screen without their styles.
std::vector<std::string> LinesOf(const std::string& title, const Sample& before, const Sample& now,
                                 PoolTableOptions options = {SortKey::kSteps, false, false}) {
  RateHistory history;
  history.Add(before, now);
  const Screen screen = ScreenOf(title, before, now, history, options);
  std::vector<std::string> lines;
  for (const std::vector<Line>* part : {&screen.head, &screen.pools}) {
    for (const Line& line : *part) {
      lines.push_back(line.text);
    }
  }
  return lines;
}

// The names in the first column of the pools.
std::vector<std::string> OrderOf(const Sample& now, SortKey sort_key, bool is_reversed = false) {
  const std::vector<std::string> lines =
      LinesOf("title", Before(), now, {sort_key, is_reversed, true});
  std::vector<std::string> names;
  for (size_t i = lines.size() - now.pools.size(); i < lines.size(); ++i) {
    names.push_back(lines[i].substr(0, lines[i].find(' ')));
  }
  return names;
}

TEST(ScreenTest, RatesAndLatenciesCoverTheSamplingInterval) {
  EXPECT_THAT(
      LinesOf("the title", Before(), Now()),
      ElementsAre(
          "the title",
          "holds     pools 3   environments 192   streams 1   workers 2   resume buffers 12.3 MB",
          "does      steps/s 640   requests/s 10.0   in 1.0 kB/s   out 1.5 MB/s",
          "queue     mean 20 ms   p50 <= 10 us   p99 <= 1 s",
          "run       mean 500 us   p50 <= 1 ms   p99 <= 1 ms", "",
          "POOL     OWNER  GAMES     MODE  ENVS  STREAM  STEPS/S  HISTORY              P50  STEPS  "
          "EPISODES  RETURN  LENGTH  AGE  LEASE",
          "pools/2  -      maze      hard    64  yes         640                 #  1.5 ms   7280  "
          "      12    3.50     120   5m      -",
          "pools/1  -      maze      -       64  no            0                 _       -   4000  "
          "       0       -       -    -    30s",
          "pools/3  alice  a,b,c,+2  -       64  no            0                 _       -      0  "
          "       0       -       -    -      -"));
}

TEST(ScreenTest, PoolsAreSortedByAnyColumnAndReversed) {
  Sample now = Now();
  now.pools[0].set_episode_count(1);
  now.pools[0].set_mean_episode_return(9);
  now.pools[0].set_mean_episode_length(20);
  now.pools[0].mutable_request_duration_p50()->set_seconds(1);
  now.pools[2].mutable_create_time()->set_seconds(1);
  EXPECT_THAT(OrderOf(now, SortKey::kSteps), ElementsAre("pools/2", "pools/1", "pools/3"));
  EXPECT_THAT(OrderOf(now, SortKey::kReturn), ElementsAre("pools/1", "pools/2", "pools/3"));
  EXPECT_THAT(OrderOf(now, SortKey::kLength), ElementsAre("pools/2", "pools/1", "pools/3"));
  EXPECT_THAT(OrderOf(now, SortKey::kLatency), ElementsAre("pools/1", "pools/2", "pools/3"));
  EXPECT_THAT(OrderOf(now, SortKey::kName), ElementsAre("pools/1", "pools/2", "pools/3"));
  EXPECT_THAT(OrderOf(now, SortKey::kName, true), ElementsAre("pools/3", "pools/2", "pools/1"));
  now.pools[0].mutable_create_time()->set_seconds(900);
  EXPECT_THAT(OrderOf(now, SortKey::kAge), ElementsAre("pools/3", "pools/2", "pools/1"));
}

TEST(RateHistoryTest, BarsAreRelativeToTheLargestRateAndTheOldestAreDropped) {
  RateHistory history;
  Sample before = Before();
  for (const int64_t steps : {8, 4, 0}) {
    Sample now = before;
    now.time += absl::Seconds(1);
    now.pools[0].set_step_count(before.pools[0].step_count() + steps);
    history.Add(before, now);
    before = now;
  }
  EXPECT_EQ(history.SparklineOf("pools/1", true), "             █▅▁");
  EXPECT_EQ(history.SparklineOf("pools/1", false), "             #=_");
  EXPECT_EQ(history.SparklineOf("pools/none", true), std::string(RateHistory::kLength, ' '));
  for (size_t i = 0; i < RateHistory::kLength; ++i) {
    Sample now = before;
    now.time += absl::Seconds(1);
    history.Add(before, now);
    before = now;
  }
  EXPECT_EQ(history.SparklineOf("pools/1", false), std::string(RateHistory::kLength, '_'));
}

TEST(TextTableTest, CharactersAreCountedInPlaceOfBytes) {
  EXPECT_THAT(AlignedLines({{"A"}, {"B", true}, {"C"}}, {{"█▁", "1", "x"}, {"y", "22", "z"}}),
              ElementsAre("A    B  C", "█▁   1  x", "y   22  z"));
  EXPECT_EQ(FirstCharacters("█▁x", 2), "█▁");
  EXPECT_EQ(FirstCharacters("█▁x", 9), "█▁x");
}

TEST(TerminalTest, StylesAreEscapeSequences) {
  EXPECT_EQ(StyledText({"text", Style::kPlain}, true), "text");
  EXPECT_EQ(StyledText({"text", Style::kTableHead}, true), "\x1b[30;42mtext\x1b[0m");
  EXPECT_EQ(StyledText({"text", Style::kTableHead}, false), "\x1b[7mtext\x1b[0m");
}

TEST(ScreenTest, IdleServerShowsZeroRatesAndDashes) {
  const std::vector<std::string> lines = LinesOf("title", Now(), Now());
  EXPECT_THAT(lines[2], HasSubstr("steps/s 0   requests/s 0.0   in 0.0 B/s"));
  EXPECT_EQ(lines[3], "queue     mean -   p50 -   p99 -");
}

TEST(ScreenTest, RestartedServerCountsFromZero) {
  const std::vector<std::string> lines = LinesOf("title", Now(), Before());
  EXPECT_THAT(lines[2], HasSubstr("steps/s 0 "));
}

TEST(ScreenTest, LatenciesBeyondTheLastBoundAreMarked) {
  Sample now = Before();
  now.load.mutable_queue_wait()->set_counts(3, 7);
  now.load.mutable_queue_wait()->set_sum_seconds(700);
  EXPECT_THAT(LinesOf("title", Before(), now)[3], HasSubstr("mean 100 s   p50 beyond"));
}

TEST(ScreenTest, ControlCharactersOfTheServerDoNotReachTheTerminal) {
  Sample now = Before();
  now.pools = {PoolOf("pools/\x1b[2J", "o\nwner", {"ga\tme"}, 0)};
  const std::vector<std::string> lines = LinesOf("ti\x1btle", Before(), now);
  EXPECT_EQ(lines[0], "ti\\x1btle");
  EXPECT_THAT(lines.back(), HasSubstr("pools/\\x1b[2J  o\\nwner  ga\\tme"));
}

TEST(ScreenTest, DrainIsShown) {
  Sample now = Now();
  now.load.set_draining(true);
  EXPECT_EQ(LinesOf("title", Before(), now)[0], "title   DRAINING");
}

TEST(ScreenTest, ClusterIsShownAboveThePools) {
  Sample now = Now();
  now.nodes.set_cluster("night\n");
  now.nodes.set_local_node("nodes/b");
  v1::Node* node = now.nodes.add_nodes();
  node->set_name("nodes/a");
  node->set_address("unix:/a\x1b.sock");
  node->set_server_version("0.1.0");
  node->set_role(v1::NODE_ROLE_FLEET);
  node->set_healthy(true);
  node = now.nodes.add_nodes();
  node->set_name("nodes/b");
  node->set_address("10.0.0.1:50051");
  node->set_server_version("0.1.0");
  node->set_role(v1::NODE_ROLE_HOST);
  node->set_environment_capacity(128);
  node->set_env_count(40);
  node->set_pool_count(3);
  node->set_stream_count(2);
  node->set_steps_per_second(1234.6);
  node->set_draining(true);
  const std::vector<std::string> lines = LinesOf("title", Before(), now);
  EXPECT_EQ(lines[6], "cluster   night\\n   nodes 2");
  EXPECT_EQ(
      lines[7],
      "NODE       ADDRESS           VERSION  ROLE   STATE     ENVS    POOLS  STREAMS  STEPS/S");
  EXPECT_EQ(lines[8],
            "nodes/a    unix:/a\\x1b.sock  0.1.0    fleet  serving   -       0      0        0");
  EXPECT_EQ(lines[9],
            "nodes/b *  10.0.0.1:50051    0.1.0    host   draining  40/128  3      2        1235");
  EXPECT_EQ(lines[10], "");
  EXPECT_THAT(lines[11], HasSubstr("POOL "));
}

}  // namespace
}  // namespace procgen_top
