#include "server/metrics/metrics.h"

#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(MetricsTest, ReturnsMayBeNegative) {
  Metrics metrics("1");
  metrics.OfGame("fruitbot", "easy").AddEpisode(-3, 20);
  EXPECT_THAT(metrics.Text(),
              AllOf(HasSubstr("procgen_episode_return_sum{game=\"fruitbot\",mode=\"easy\"} -3"),
                    HasSubstr("{game=\"fruitbot\",mode=\"easy\",le=\"-5\"} 0"),
                    HasSubstr("{game=\"fruitbot\",mode=\"easy\",le=\"-1\"} 1")));
}

TEST(MetricsTest, ThreadsLoseNoCount) {
  constexpr int kThreadCount = 4;
  constexpr int kRounds = 1000;
  Metrics metrics("1");
  std::vector<std::thread> threads;
  threads.reserve(kThreadCount);
  for (int i = 0; i < kThreadCount; ++i) {
    threads.emplace_back([&metrics] {
      for (int round = 0; round < kRounds; ++round) {
        metrics.OfGame("maze", "hard").AddSteps(1);
        metrics.AddSentBytes(2);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_THAT(metrics.Text(), AllOf(HasSubstr("mode=\"hard\"} 4000\n"),
                                    HasSubstr("procgen_stream_sent_bytes_total 8000\n")));
}

}  // namespace
}  // namespace procgen
