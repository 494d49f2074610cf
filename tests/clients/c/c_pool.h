#ifndef TESTS_CLIENTS_C_C_POOL_H_
#define TESTS_CLIENTS_C_C_POOL_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "clients/c/procgen.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/batch_buffers.h"

namespace procgen {

struct DestroyPool {
  void operator()(ProcgenPool* pool) const { procgen_pool_destroy(pool); }
};
using CPool = std::unique_ptr<ProcgenPool, DestroyPool>;

// Options with defaults and their own names of games.
struct COptions : ProcgenPoolOptions {
  explicit COptions(const char* game, int32_t count = 4) : name(game) {
    procgen_pool_options_init(this, sizeof(ProcgenPoolOptions));
    games = &name;
    game_count = 1;
    env_count = count;
    distribution_mode = PROCGEN_EASY;
    rand_seed = 7;
    has_rand_seed = 1;
  }
  COptions(const COptions&) = delete;
  COptions& operator=(const COptions&) = delete;

  const char* name;
};

inline CPool Made(const ProcgenPoolOptions& options) {
  ProcgenPool* pool = nullptr;
  EXPECT_EQ(procgen_pool_create(&options, &pool), PROCGEN_OK) << procgen_error_message();
  return CPool(pool);
}

// The rows of `buffers` from `first` on.
inline ProcgenBatch BatchIn(BatchBuffers& buffers, int32_t first = 0) {
  const Batch rows = buffers.Rows(first, static_cast<int32_t>(buffers.rewards.size()) - first);
  return {.struct_size = sizeof(ProcgenBatch),
          .observations = rows.observations.data(),
#define PROCGEN_DATA(type, name, member) .name = rows.name.data(),
          PROCGEN_BATCH_NUMBERS(PROCGEN_DATA)
#undef PROCGEN_DATA
              .final_observations = rows.final_observations.data()};
}

inline ProcgenStep StepOf(const std::vector<int32_t>& actions, int32_t first_env = 0) {
  return {.struct_size = sizeof(ProcgenStep),
          .first_env = first_env,
          .env_count = static_cast<int32_t>(actions.size()),
          .actions = actions.data(),
          .repeat_count = 1,
          .next_level_count = 0,
          .next_levels = nullptr,
          .resets = nullptr,
          .reset_count = 0,
          .annotations = nullptr,
          .annotation_count = 0};
}

// Action of environment i at step t: any, but the same in each run.
inline std::vector<int32_t> ActionsAt(int32_t step, int32_t env_count) {
  std::vector<int32_t> actions(static_cast<size_t>(env_count));
  for (int32_t i = 0; i < env_count; ++i) {
    actions[static_cast<size_t>(i)] = (step * 7 + i * 5 + step * i) % PROCGEN_ACTION_COUNT;
  }
  return actions;
}

// The batches of `count` further steps of the whole pool.
inline std::vector<BatchBuffers> Steps(ProcgenPool* pool, int32_t env_count, int32_t begin,
                                       int32_t count) {
  std::vector<BatchBuffers> batches;
  for (int32_t t = begin; t < begin + count; ++t) {
    const std::vector<int32_t> actions = ActionsAt(t, env_count);
    const ProcgenStep step = StepOf(actions);
    BatchBuffers& buffers = batches.emplace_back(env_count);
    const ProcgenBatch batch = BatchIn(buffers);
    EXPECT_EQ(procgen_step(pool, &step, &batch), PROCGEN_OK) << procgen_error_message();
  }
  return batches;
}

}  // namespace procgen

#endif  // TESTS_CLIENTS_C_C_POOL_H_
