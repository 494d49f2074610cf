// Bad input to pools on servers is a code and a message, and the pool continues.

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/clients/c/remote_fixture.h"

namespace procgen {
namespace {

using testing::Each;
using testing::HasSubstr;

class RemoteErrorTest : public RemoteTest {
 protected:
  // Creates a pool, which fails with `code`; returns the message.
  static std::string CreateError(const CConnection& connection, const ProcgenPoolOptions& options,
                                 ProcgenCode code, const char* pool_id = nullptr,
                                 int32_t encoding = PROCGEN_RAW) {
    ProcgenServerPoolOptions server_options = {};
    server_options.struct_size = sizeof(server_options);
    server_options.pool_id = pool_id;
    server_options.encoding = encoding;
    ProcgenPool* pool = nullptr;
    EXPECT_EQ(procgen_connection_create_pool(connection.get(), &options, &server_options, &pool),
              code);
    EXPECT_EQ(pool, nullptr);
    return procgen_error_message();
  }

  static ProcgenCode Step(const CPool& pool, const ProcgenStep& step, BatchBuffers& buffers) {
    const ProcgenBatch batch = BatchIn(buffers);
    return procgen_step(pool.get(), &step, &batch);
  }
};

TEST_F(RemoteErrorTest, ABadOptionIsNamed) {
  const CConnection connection = Connected();
  EXPECT_THAT(CreateError(connection, COptions("pong"), PROCGEN_NOT_FOUND), HasSubstr("pong"));
  EXPECT_THAT(CreateError(connection, COptions("maze", 0), PROCGEN_INVALID_ARGUMENT),
              HasSubstr("env_count is 0"));
  COptions options("maze");
  options.art = "/some/folder";
  EXPECT_THAT(CreateError(connection, options, PROCGEN_INVALID_ARGUMENT),
              HasSubstr("art is /some/folder, must be null"));
  options.art = nullptr;
  EXPECT_THAT(CreateError(connection, options, PROCGEN_INVALID_ARGUMENT, nullptr, 2),
              HasSubstr("encoding is 2, must be one of 0, 1"));
  EXPECT_THAT(CreateError(connection, options, PROCGEN_INVALID_ARGUMENT, "A b"), HasSubstr("A b"));
}

TEST_F(RemoteErrorTest, InvalidNamesAndLabelsAreNamed) {
  const CConnection connection = Connected();
  const COptions options("maze");
  ProcgenPool* pool = nullptr;
  const char* labels[] = {"seed=3", "baseline"};
  ProcgenServerPoolOptions server_options = {};
  server_options.struct_size = sizeof(server_options);
  server_options.labels = labels;
  server_options.label_count = 2;
  EXPECT_EQ(procgen_connection_create_pool(connection.get(), &options, &server_options, &pool),
            PROCGEN_INVALID_ARGUMENT);
  EXPECT_THAT(procgen_error_message(), HasSubstr("labels[1] is 'baseline', must be 'key=value'"));
  server_options.label_count = 1;
  server_options.display_name = "a\nb";
  EXPECT_EQ(procgen_connection_create_pool(connection.get(), &options, &server_options, &pool),
            PROCGEN_INVALID_ARGUMENT);
  EXPECT_THAT(procgen_error_message(), HasSubstr("spec.display_name is 'a\\nb'"));
}

TEST_F(RemoteErrorTest, ARequestThatTheServerRejectsChangesNothing) {
  const CConnection connection = Connected();
  const CPool pool = MadeOn(connection, COptions("maze"), PROCGEN_DELTA_ZSTD);
  BatchBuffers buffers(4);
  const std::vector<int32_t> actions(4, 4);
  const std::vector<float> values(8);
  const ProcgenAnnotation annotation = {.name = "a*b", .values = values.data(), .value_count = 2};
  ProcgenStep step = StepOf(actions);
  step.annotations = &annotation;
  step.annotation_count = 1;
  EXPECT_EQ(Step(pool, step, buffers), PROCGEN_INVALID_ARGUMENT);
  EXPECT_THAT(procgen_error_message(), HasSubstr("a*b"));
  EXPECT_EQ(Steps(pool.get(), 4, 0, 20), Steps(Made(COptions("maze")).get(), 4, 0, 20));
  const int32_t source = 0;
  const int32_t target = 9;
  EXPECT_EQ(procgen_clone_states(pool.get(), &source, &target, 1), PROCGEN_INVALID_ARGUMENT);
  const std::string damaged = "no snapshot";
  const size_t offsets[] = {0, damaged.size()};
  EXPECT_EQ(procgen_restore_states(pool.get(), &source, 1,
                                   reinterpret_cast<const uint8_t*>(damaged.data()), offsets),
            PROCGEN_DATA_LOSS);
  EXPECT_EQ(Step(pool, StepOf(actions), buffers), PROCGEN_OK);
}

TEST_F(RemoteErrorTest, AnErrorAnswersItsOwnRequestOnly) {
  COptions options("maze");
  options.autoreset_mode = PROCGEN_DISABLED;
  const CConnection connection = Connected();
  const CPool pool = MadeOn(connection, options, PROCGEN_DELTA_ZSTD);
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  const std::vector<int32_t> ends(4, -1);
  const ProcgenStep step = StepOf(ends);
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(procgen_send_step(pool.get(), &step, &batch), PROCGEN_OK);
  }
  ASSERT_EQ(procgen_send_observe(pool.get(), 0, 4, &batch), PROCGEN_OK);
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_OK);
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_FAILED_PRECONDITION);
  EXPECT_THAT(procgen_error_message(), HasSubstr("reset"));
  EXPECT_EQ(procgen_receive(pool.get(), 10), PROCGEN_FAILED_PRECONDITION);
  EXPECT_EQ(procgen_unanswered_count(pool.get()), 1);
  std::fill(buffers.terminated.begin(), buffers.terminated.end(), 0);
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_OK) << procgen_error_message();
  EXPECT_THAT(buffers.terminated, Each(1));
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_FAILED_PRECONDITION);
}

TEST_F(RemoteErrorTest, OnlyAnIdlePoolIsSteppedSavedOrDrawn) {
  const CConnection connection = Connected();
  const CPool pool = MadeOn(connection, COptions("maze"));
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  for (int i = 0; i < 16; ++i) {
    ASSERT_EQ(procgen_send_observe(pool.get(), 0, 4, &batch), PROCGEN_OK);
  }
  EXPECT_EQ(procgen_send_observe(pool.get(), 0, 4, &batch), PROCGEN_FAILED_PRECONDITION);
  EXPECT_THAT(procgen_error_message(), HasSubstr("16 requests are unanswered, at most 16"));
  EXPECT_EQ(procgen_observe(pool.get(), 0, 4, &batch), PROCGEN_FAILED_PRECONDITION);
  std::vector<uint8_t> frame(size_t{64} * 64 * 3);
  EXPECT_EQ(procgen_render(pool.get(), 0, 64, 0, frame.data()), PROCGEN_FAILED_PRECONDITION);
  for (int i = 0; i < 16; ++i) {
    EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_OK);
  }
  EXPECT_EQ(procgen_render(pool.get(), 0, 64, 0, frame.data()), PROCGEN_OK);
}

TEST_F(RemoteErrorTest, NullArraysAreNotWritten) {
  const CConnection connection = Connected();
  const CPool pool = MadeOn(connection, COptions("maze"));
  const std::vector<int32_t> ends = {4, -1, 4, -1};
  BatchBuffers buffers(4);
  const BatchBuffers untouched = buffers;
  ProcgenBatch batch = BatchIn(buffers);
  batch.observations = nullptr;
  batch.rewards = nullptr;
  const ProcgenStep step = StepOf(ends);
  ASSERT_EQ(procgen_step(pool.get(), &step, &batch), PROCGEN_OK) << procgen_error_message();
  EXPECT_EQ(buffers.observations, untouched.observations);
  EXPECT_EQ(buffers.rewards, untouched.rewards);
  EXPECT_THAT(buffers.fingerprints, testing::ElementsAre(0, testing::Ne(0), 0, testing::Ne(0)));
  ProcgenBatch none = {};
  none.struct_size = sizeof(none);
  EXPECT_EQ(procgen_step(pool.get(), &step, &none), PROCGEN_OK);
}

}  // namespace
}  // namespace procgen
