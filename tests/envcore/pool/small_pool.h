#ifndef TESTS_ENVCORE_POOL_SMALL_POOL_H_
#define TESTS_ENVCORE_POOL_SMALL_POOL_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "envcore/pool/pool.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"

namespace procgen {

// Number of environments of a small pool.
inline constexpr int32_t kEnvCount = 4;

inline PoolOptions OptionsOf(std::vector<std::string> games, int32_t env_count = kEnvCount) {
  PoolOptions options;
  options.games = std::move(games);
  options.env_count = env_count;
  options.environment.distribution_mode = DistributionMode::kEasy;
  return options;
}

inline std::unique_ptr<Pool> MadePool(const PoolOptions& options, int32_t thread_count = 0) {
  auto pool = Pool::Create(options, std::make_shared<WorkerPool>(thread_count));
  EXPECT_TRUE(pool.ok()) << pool.status();
  return *std::move(pool);
}

inline std::unique_ptr<Pool> MazePool() { return MadePool(OptionsOf({"maze"})); }

// A pool of one game with the given observation format.
inline std::unique_ptr<Pool> FormattedPool(
    const std::string& game, const ObservationFormat& format,
    AutoresetMode autoreset_mode = AutoresetMode::kSameStep) {
  PoolOptions options = OptionsOf({game});
  options.environment.rand_seed = 5;
  options.autoreset_mode = autoreset_mode;
  options.observation_format = format;
  return MadePool(options);
}

// The observation of environment i, or frame i of a stack, of `bytes` bytes.
inline std::vector<uint8_t> RowOf(const std::vector<uint8_t>& observations, size_t bytes,
                                  size_t i) {
  const auto start = observations.begin() + static_cast<std::ptrdiff_t>(i * bytes);
  return {start, start + static_cast<std::ptrdiff_t>(bytes)};
}

inline std::vector<int32_t> AllTake(int32_t action, int32_t count = kEnvCount) {
  // NOLINTNEXTLINE(modernize-return-braced-init-list): that would be a list of these two.
  return std::vector<int32_t>(static_cast<size_t>(count), action);
}

inline BatchBuffers Observed(Pool& pool) {
  BatchBuffers buffers(pool.env_count(), pool.observation_bytes());
  EXPECT_TRUE(pool.Observe(0, pool.env_count(), buffers.Whole()).ok());
  return buffers;
}

inline BatchBuffers Stepped(Pool& pool, const std::vector<int32_t>& actions) {
  BatchBuffers buffers(pool.env_count(), pool.observation_bytes());
  EXPECT_TRUE(pool.Step({.count = pool.env_count(), .actions = actions}, buffers.Whole()).ok());
  return buffers;
}

}  // namespace procgen

#endif  // TESTS_ENVCORE_POOL_SMALL_POOL_H_
