// Bad input is a code and a message, and changes nothing.

#include <cstdint>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/clients/c/c_pool.h"

namespace procgen {
namespace {

using testing::HasSubstr;

std::string CreateError(const ProcgenPoolOptions& options, ProcgenCode code) {
  ProcgenPool* pool = nullptr;
  EXPECT_EQ(procgen_pool_create(&options, &pool), code);
  EXPECT_EQ(pool, nullptr);
  return procgen_error_message();
}

TEST(ErrorTest, EachBadOptionIsNamed) {
  const auto error = [](auto change, ProcgenCode code = PROCGEN_INVALID_ARGUMENT) {
    COptions options("coinrun");
    change(options);
    return CreateError(options, code);
  };
  EXPECT_THAT(error([](COptions& o) { o.name = "pong"; }, PROCGEN_NOT_FOUND), HasSubstr("pong"));
  EXPECT_THAT(error([](COptions& o) { o.games = nullptr; }), HasSubstr("games[0] is null"));
  EXPECT_THAT(error([](COptions& o) { o.game_count = 65; }),
              HasSubstr("game_count is 65, must be in [1, 64]"));
  EXPECT_THAT(error([](COptions& o) { o.env_count = 0; }), HasSubstr("env_count is 0"));
  EXPECT_THAT(error([](COptions& o) { o.distribution_mode = 3; }),
              HasSubstr("distribution_mode is 3, must be one of 0, 1, 2, 10, 20"));
  EXPECT_THAT(error([](COptions& o) { o.distribution_mode = PROCGEN_MEMORY; }),
              HasSubstr("memory"));
  EXPECT_THAT(error([](COptions& o) { o.num_levels = -1; }), HasSubstr("num_levels is -1"));
  EXPECT_THAT(error([](COptions& o) { o.autoreset_mode = 3; }), HasSubstr("autoreset_mode is 3"));
  EXPECT_THAT(error([](COptions& o) { o.layout = -1; }), HasSubstr("layout is -1"));
  EXPECT_THAT(error([](COptions& o) { o.screen_size = 15; }), HasSubstr("15"));
  EXPECT_THAT(error([](COptions& o) { o.frame_stack = 17; }), HasSubstr("17"));
  EXPECT_THAT(error([](COptions& o) { o.num_threads = 1025; }),
              HasSubstr("num_threads is 1025, must be in [-1, 1024]"));
  EXPECT_THAT(error([](COptions& o) { o.art = "/no/such/folder"; }, PROCGEN_NOT_FOUND),
              HasSubstr("/no/such/folder"));
}

TEST(ErrorTest, NullPointersAreErrors) {
  ProcgenPool* pool = nullptr;
  EXPECT_EQ(procgen_pool_create(nullptr, &pool), PROCGEN_INVALID_ARGUMENT);
  EXPECT_STREQ(procgen_error_message(), "options is null");
  EXPECT_EQ(procgen_step(nullptr, nullptr, nullptr), PROCGEN_INVALID_ARGUMENT);
  EXPECT_STREQ(procgen_error_message(), "pool is null");
  const CPool made = Made(COptions("maze"));
  EXPECT_EQ(procgen_step(made.get(), nullptr, nullptr), PROCGEN_INVALID_ARGUMENT);
  EXPECT_STREQ(procgen_error_message(), "step is null");
  procgen_pool_destroy(nullptr);
}

TEST(ErrorTest, ArraysThatAreMissingOrOfNegativeLengthAreErrors) {
  const CPool pool = Made(COptions("maze"));
  BatchBuffers buffers(4);
  ProcgenBatch batch = BatchIn(buffers);
  const std::vector<int32_t> actions(4, 4);
  ProcgenStep step = StepOf(actions);
  const auto error = [&](ProcgenCode code) {
    EXPECT_EQ(code, PROCGEN_INVALID_ARGUMENT);
    return std::string(procgen_error_message());
  };
  step.reset_count = -1;
  EXPECT_EQ(error(procgen_step(pool.get(), &step, &batch)), "reset_count is -1");
  step.reset_count = 0;
  step.next_level_count = 2;
  EXPECT_EQ(error(procgen_step(pool.get(), &step, &batch)), "next_levels is null, its length is 2");
  step = StepOf(actions);
  step.struct_size = 0;
  EXPECT_EQ(error(procgen_step(pool.get(), &step, &batch)),
            "step.struct_size is 0, must be the size of the struct");
  step = StepOf(actions);
  batch.struct_size = 0;
  EXPECT_EQ(error(procgen_step(pool.get(), &step, &batch)),
            "batch.struct_size is 0, must be the size of the struct");
  EXPECT_EQ(error(procgen_reset(pool.get(), 0, 4, nullptr, 1, &batch)),
            "resets is null, its length is 1");
  const int32_t environment = 0;
  size_t offsets[2] = {};
  EXPECT_EQ(error(procgen_save_states(pool.get(), &environment, -1, nullptr, 0, offsets)),
            "count is -1");
  EXPECT_EQ(error(procgen_save_states(pool.get(), &environment, 1, nullptr, 0, nullptr)),
            "offsets is null");
  EXPECT_EQ(error(procgen_save_states(pool.get(), &environment, 1, nullptr, 100, offsets)),
            "data is null, its length is 100");
  EXPECT_EQ(error(procgen_restore_states(pool.get(), &environment, 1, nullptr, offsets)),
            "data is null");
  const uint8_t byte = 0;
  offsets[0] = 8;
  EXPECT_EQ(error(procgen_restore_states(pool.get(), &environment, 1, &byte, offsets)),
            "offsets[1] is 0, less than the one before, 8");
  EXPECT_EQ(error(procgen_clone_states(pool.get(), nullptr, &environment, 1)),
            "sources is null, its length is 1");
  ProcgenPoolInfo info = {};
  EXPECT_EQ(error(procgen_pool_info(pool.get(), &info)),
            "info.struct_size is 0, must be the size of the struct");
}

TEST(ErrorTest, AWrongActionOrSliceStepsNothing) {
  const CPool pool = Made(COptions("maze"));
  BatchBuffers buffers(4);
  const BatchBuffers untouched = buffers;
  const ProcgenBatch batch = BatchIn(buffers);
  const std::vector<int32_t> wrong = {4, 15, 4, 4};
  ProcgenStep step = StepOf(wrong);
  EXPECT_EQ(procgen_step(pool.get(), &step, &batch), PROCGEN_INVALID_ARGUMENT);
  EXPECT_THAT(procgen_error_message(), HasSubstr("action 15 of environment 1 is not in [-1, 14]"));
  const std::vector<int32_t> actions(4, 4);
  step = StepOf(actions, 1);
  EXPECT_EQ(procgen_send_step(pool.get(), &step, &batch), PROCGEN_INVALID_ARGUMENT);
  EXPECT_THAT(procgen_error_message(), HasSubstr("the slice is 4 environments from 1"));
  step = StepOf(actions);
  step.env_count = std::numeric_limits<int32_t>::min();
  EXPECT_EQ(procgen_step(pool.get(), &step, &batch), PROCGEN_INVALID_ARGUMENT);
  step = StepOf(actions);
  step.actions = nullptr;
  EXPECT_EQ(procgen_step(pool.get(), &step, &batch), PROCGEN_INVALID_ARGUMENT);
  EXPECT_EQ(procgen_unanswered_count(pool.get()), 0);
  EXPECT_EQ(buffers, untouched);
}

TEST(ErrorTest, MessagesBelongToTheCallingThread) {
  EXPECT_EQ(procgen_step(nullptr, nullptr, nullptr), PROCGEN_INVALID_ARGUMENT);
  std::thread other([] {
    EXPECT_STREQ(procgen_error_message(), "");
    EXPECT_EQ(procgen_pool_create(nullptr, nullptr), PROCGEN_INVALID_ARGUMENT);
  });
  other.join();
  EXPECT_STREQ(procgen_error_message(), "pool is null");
}

TEST(ErrorTest, AProgramWithShorterStructsWorks) {
  COptions options("maze");
  options.struct_size = offsetof(ProcgenPoolOptions, autoreset_mode);
  options.autoreset_mode = 99;  // behind the end of that program's struct
  EXPECT_NE(Made(options), nullptr);
}

}  // namespace
}  // namespace procgen
