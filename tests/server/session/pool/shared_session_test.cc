// A pool in shared memory.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/session/pool/pool_session.h"
#include "tests/server/session/test_pool_context.h"
#include "tests/server/session/test_sink.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::HasSubstr;

const AttachOptions kResumable = {
    .requests_in_flight_max = 2, .resumable = true, .held_batches_max = 1};

class SharedSessionTest : public testing::Test {
 protected:
  std::unique_ptr<PoolSession> Make() {
    PoolOptions options;
    options.games = {"maze"};
    options.env_count = 2;
    absl::StatusOr<std::unique_ptr<Pool>> pool =
        Pool::Create(options, std::make_shared<WorkerPool>(1));
    EXPECT_THAT(pool, IsOk());
    return std::make_unique<PoolSession>("", "pools/7", context_.Backend(*std::move(pool)),
                                         absl::InfiniteDuration(), context_.Get(), Encoding::kRaw,
                                         shared_memory_dir_.get());
  }

  absl::Status Attach(const AttachOptions& options) {
    absl::Status status;
    session_->Attach(
        options, [](StreamEnd /*why*/, const absl::Status& /*reason*/) {},
        [&](absl::Status attached) { status = std::move(attached); });
    if (!status.ok()) {
      return status;
    }
    absl::Notification done;
    session_->ShareMemory(options, [&](absl::Status shared) {
      status = std::move(shared);
      done.Notify();
    });
    done.WaitForNotification();
    return status;
  }

  // The batch slot of request `number`; -1 if it was executed before.
  absl::StatusOr<int32_t> Ask(int64_t number, const std::vector<int32_t>& released = {}) {
    Request request = RequestOf(number);
    request.released = released;
    const auto sink = std::make_shared<TestSink>();
    session_->Execute(&request, sink);
    if (!sink->status().ok()) {
      return sink->status();
    }
    return request.shared_batch;
  }

  const TemporaryFolder folder_;
  const std::unique_ptr<SharedMemoryDir> shared_memory_dir_ =
      *SharedMemoryDir::Open(folder_.path());
  TestPoolContext context_;
  std::unique_ptr<PoolSession> session_ = Make();
};

TEST_F(SharedSessionTest, RequestsGetFreeBatches) {
  ASSERT_THAT(Attach(kResumable), IsOk());
  EXPECT_EQ(session_->shared_batch_slots()->batch_count(), 3);
  EXPECT_THAT(Ask(1), IsOkAndHolds(0));
  EXPECT_THAT(Ask(2), IsOkAndHolds(1));
  EXPECT_THAT(Ask(3, {0}), IsOkAndHolds(0)) << "request 1 cannot be repeated";
  EXPECT_THAT(Ask(4), IsOkAndHolds(2));
  EXPECT_THAT(Ask(5), StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("holds 3")));
  EXPECT_EQ(session_->next_sequence_number(), 5);
  EXPECT_THAT(Ask(5, {1}), IsOkAndHolds(1));
}

TEST_F(SharedSessionTest, ResumedStreamHoldsListedAndRepeatedBatches) {
  ASSERT_THAT(Attach(kResumable), IsOk());
  ASSERT_THAT(Ask(1), IsOkAndHolds(0));
  ASSERT_THAT(Ask(2), IsOkAndHolds(1));
  session_->Detach();
  AttachOptions again = kResumable;
  again.held_batches = {0};
  ASSERT_THAT(Attach(again), IsOk());
  EXPECT_THAT(Ask(2), IsOkAndHolds(-1));
  EXPECT_THAT(Ask(3), IsOkAndHolds(2));
  EXPECT_THAT(Ask(4), StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("holds 3")));
}

TEST_F(SharedSessionTest, NonResumingStreamHasAllBatches) {
  ASSERT_THAT(Attach(kResumable), IsOk());
  ASSERT_THAT(Ask(1), IsOkAndHolds(0));
  ASSERT_THAT(Ask(2), IsOkAndHolds(1));
  session_->Detach();
  ASSERT_THAT(Attach({.requests_in_flight_max = 2, .held_batches_max = 1}), IsOk());
  for (const int64_t number : {3, 4, 5}) {
    EXPECT_THAT(Ask(number), IsOkAndHolds(static_cast<int32_t>(number - 3)));
  }
}

TEST_F(SharedSessionTest, AttachBeyondTheLimitIsRejectedAndTakesNothing) {
  const int64_t others = context_.shared_memory_bytes.bytes_max() - 4096;
  ASSERT_TRUE(context_.shared_memory_bytes.Change(0, others));
  EXPECT_THAT(Attach(kResumable), StatusIs(absl::StatusCode::kResourceExhausted,
                                           HasSubstr("limit shared_memory_bytes_max")));
  session_->Detach();
  EXPECT_EQ(context_.shared_memory_bytes.reserved_bytes(), others);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
  context_.shared_memory_bytes.Change(others, 0);
  EXPECT_THAT(Attach(kResumable), IsOk());
  EXPECT_EQ(context_.shared_memory_bytes.reserved_bytes(),
            session_->shared_batch_slots()->size_bytes());
  session_->Detach();
  session_ = nullptr;
  EXPECT_EQ(context_.shared_memory_bytes.reserved_bytes(), 0);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(SharedSessionTest, KeptResponsesTakeNoObservationMemory) {
  ASSERT_THAT(Attach(kResumable), IsOk());
  EXPECT_LT(context_.resume_buffer_bytes.reserved_bytes(), 12288);
}

}  // namespace
}  // namespace procgen
