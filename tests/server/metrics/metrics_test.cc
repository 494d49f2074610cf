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

TEST(MetricsTest, GaugesAreEvaluatedOnRead) {
  Metrics metrics("1");
  int pool_count = 0;
  metrics.ReadGaugesFrom([&pool_count] {
    return ServerGauges{
        .pool_count = ++pool_count, .env_count = 9, .worker_count = 2, .draining = true};
  });
  EXPECT_THAT(metrics.Text(),
              AllOf(HasSubstr("procgen_pools 1\n"), HasSubstr("procgen_workers 2\n"),
                    HasSubstr("procgen_environments 9\n"), HasSubstr("procgen_draining 1\n")));
  EXPECT_THAT(metrics.Text(), HasSubstr("procgen_pools 2\n"));
}

TEST(MetricsTest, CountsRequestsBytesAndErrors) {
  Metrics metrics("1.2.3");
  metrics.AddRequest(absl::Microseconds(5), absl::Milliseconds(3));
  metrics.AddReceivedBytes(100);
  metrics.AddSentBytes(12288);
  metrics.AddError("PoolService/GetPool", absl::StatusCode::kNotFound);
  EXPECT_THAT(
      metrics.Text(),
      AllOf(HasSubstr("procgen_request_queue_seconds_bucket{le=\"1e-05\"} 1"),
            HasSubstr("procgen_request_run_seconds_sum 0.003"),
            HasSubstr("procgen_stream_received_bytes_total 100"),
            HasSubstr("procgen_stream_sent_bytes_total 12288"),
            HasSubstr("procgen_errors_total{code=\"NOT_FOUND\",method=\"PoolService/GetPool\"} 1"),
            HasSubstr("procgen_build_info{version=\"1.2.3\"} 1")));
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
