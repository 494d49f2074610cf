#include "server/metrics/atomic_histogram.h"

#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

constexpr double kBounds[] = {1, 10};

TEST(AtomicHistogramTest, CountsValuesUpToEachBoundAndBeyond) {
  AtomicHistogram histogram(kBounds);
  for (const double value : {-4.0, 1.0, 1.5, 10.0, 11.0, 1000.0}) {
    histogram.Add(value);
  }
  const HistogramCounts counted = histogram.Counts();
  EXPECT_THAT(counted.bounds, ElementsAre(1, 10));
  EXPECT_THAT(counted.counts, ElementsAre(2, 2, 2));
  EXPECT_EQ(counted.sum, 1019.5);
}

TEST(AtomicHistogramTest, ThreadsLoseNoValue) {
  constexpr int kThreadCount = 4;
  constexpr int kRounds = 1000;
  AtomicHistogram histogram(kBounds);
  std::vector<std::thread> threads;
  threads.reserve(kThreadCount);
  for (int i = 0; i < kThreadCount; ++i) {
    threads.emplace_back([&histogram] {
      for (int round = 0; round < kRounds; ++round) {
        histogram.Add(2);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_THAT(histogram.Counts().counts, ElementsAre(0, kThreadCount * kRounds, 0));
  EXPECT_EQ(histogram.Counts().sum, 2 * kThreadCount * kRounds);
}

}  // namespace
}  // namespace procgen
