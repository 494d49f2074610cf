// Slices, requests sent ahead, resets, next levels and samplers.

#include <cstdint>
#include <thread>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/clients/c/c_pool.h"

namespace procgen {
namespace {

using testing::Each;
using testing::HasSubstr;

class RequestTest : public testing::TestWithParam<int32_t> {
 protected:
  static CPool Pool(const char* game = "maze") {
    COptions options(game);
    options.num_threads = GetParam();
    return Made(options);
  }
};

TEST_P(RequestTest, AnErrorAnswersItsOwnRequestOnly) {
  COptions options("maze");
  options.autoreset_mode = PROCGEN_DISABLED;
  options.num_threads = GetParam();
  const CPool pool = Made(options);
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  const std::vector<int32_t> ends(4, -1);
  const ProcgenStep step = StepOf(ends);
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(procgen_send_step(pool.get(), &step, &batch), PROCGEN_OK);
  }
  ASSERT_EQ(procgen_send_observe(pool.get(), 0, 4, &batch), PROCGEN_OK);
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_OK);
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_FAILED_PRECONDITION);
  EXPECT_THAT(procgen_error_message(), HasSubstr("reset it before it is stepped"));
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_OK);
  EXPECT_THAT(buffers.terminated, Each(1));
}

TEST_P(RequestTest, OnlyAnIdlePoolIsSteppedSavedOrDrawn) {
  const CPool pool = Pool();
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  ASSERT_EQ(procgen_send_observe(pool.get(), 0, 4, &batch), PROCGEN_OK);
  EXPECT_EQ(procgen_observe(pool.get(), 0, 4, &batch), PROCGEN_FAILED_PRECONDITION);
  EXPECT_THAT(procgen_error_message(), HasSubstr("1 requests are unanswered"));
  std::vector<uint8_t> frame(64 * 64 * 3);
  EXPECT_EQ(procgen_render(pool.get(), 0, 64, 0, frame.data()), PROCGEN_FAILED_PRECONDITION);
  EXPECT_EQ(procgen_receive(pool.get(), 10), PROCGEN_OK);
  EXPECT_EQ(procgen_render(pool.get(), 0, 64, 0, frame.data()), PROCGEN_OK);
  EXPECT_EQ(procgen_receive(pool.get(), -1), PROCGEN_FAILED_PRECONDITION);
}

TEST_P(RequestTest, OneThreadMaySendWhileAnotherReceives) {
  constexpr int kCount = 500;
  const CPool pool = Pool();
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  const std::vector<int32_t> actions(4, 7);
  const ProcgenStep step = StepOf(actions);
  std::thread sender([&] {
    for (int i = 0; i < kCount; ++i) {
      EXPECT_EQ(procgen_send_step(pool.get(), &step, &batch), PROCGEN_OK);
    }
  });
  for (int received = 0; received < kCount;) {
    received += procgen_receive(pool.get(), -1) == PROCGEN_OK ? 1 : 0;  // else none is sent yet
  }
  sender.join();
  EXPECT_EQ(procgen_unanswered_count(pool.get()), 0);
  EXPECT_EQ(procgen_observe(pool.get(), 0, 4, &batch), PROCGEN_OK);
}

TEST_P(RequestTest, APoolMayBeDestroyedWithUnansweredRequests) {
  CPool pool = Pool();
  BatchBuffers buffers(4);
  const ProcgenBatch batch = BatchIn(buffers);
  const std::vector<int32_t> actions(4, 4);
  ProcgenStep step = StepOf(actions);
  step.repeat_count = 1000;
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(procgen_send_step(pool.get(), &step, &batch), PROCGEN_OK);
  }
  pool = nullptr;
}

INSTANTIATE_TEST_SUITE_P(Threads, RequestTest, testing::Values(0, 2),
                         [](const auto& info) { return "Threads" + std::to_string(info.param); });

}  // namespace
}  // namespace procgen
