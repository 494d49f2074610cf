// Replay of requests that an earlier process accepted, on a pool that next_error or that completes
// calls before they return, as a fleet's pool does.

#include "server/rpc/step/resume_replay.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "absl/time/time.h"
#include "gmock/gmock.h"
#include "grpc/grpc.h"
#include "gtest/gtest.h"
#include "procgen/v1/step.pb.h"
#include "server/concurrency/steady_time.h"
#include "server/session/backend/local_pool.h"
#include "tests/server/session/test_pool_context.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

// A pool that completes each part within StepAsync.
class SynchronousPool final : public PoolBackend {
 public:
  // `next_error`: the error of the next part; OK: it is stepped. Notifies `destroyed` in the
  // destructor.
  SynchronousPool(std::unique_ptr<PoolBackend> pool, std::function<absl::Status()> next_error,
                  absl::Notification* destroyed)
      : pool_(std::move(pool)), next_error_(std::move(next_error)), destroyed_(destroyed) {}
  ~SynchronousPool() override {
    pool_ = nullptr;
    destroyed_->Notify();
  }

  const PoolOptions& options() const override { return pool_->options(); }
  bool AwaitsReset(int32_t environment) const override { return pool_->AwaitsReset(environment); }
  void BeginRequest(const Request& request, const Batch& first_part) override {
    pool_->BeginRequest(request, first_part);
  }
  void StepAsync(const StepInput& part, const Batch& batch, Done done) override {
    const char here = 0;
    NoteStack(reinterpret_cast<intptr_t>(&here));
    absl::Status status = next_error_();
    if (status.ok()) {
      absl::Notification stepped;
      pool_->StepAsync(part, batch, [&](absl::Status result) {
        status = std::move(result);
        stepped.Notify();
      });
      stepped.WaitForNotification();
    }
    done(std::move(status));
  }
  void SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler, Done done) override {
    pool_->SetLevelSampler(std::move(level_sampler), std::move(done));
  }
  void SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) override {
    pool_->SaveStates(environments, std::move(take), std::move(done));
  }
  void RestoreStates(std::vector<StateToRestore> states, Done done) override {
    pool_->RestoreStates(std::move(states), std::move(done));
  }
  void CloneStates(std::vector<StateToClone> pairs, Done done) override {
    pool_->CloneStates(std::move(pairs), std::move(done));
  }
  void CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                     CaptureDone done) override {
    pool_->CaptureScenes(environments, view, size_px, std::move(done));
  }

  int part_count() const { return part_count_; }
  // Distance between the highest and the lowest stack frame of StepAsync.
  intptr_t stack_bytes() const { return highest_ - lowest_; }

 private:
  void NoteStack(intptr_t here) {
    lowest_ = part_count_ == 0 ? here : std::min<intptr_t>(lowest_, here);
    highest_ = part_count_ == 0 ? here : std::max<intptr_t>(highest_, here);
    ++part_count_;
  }

  std::unique_ptr<PoolBackend> pool_;
  const std::function<absl::Status()> next_error_;
  absl::Notification* const destroyed_;
  std::atomic<int> part_count_ = 0;
  std::atomic<intptr_t> lowest_ = 0;
  std::atomic<intptr_t> highest_ = 0;
};

class ResumeReplayTest : public testing::Test {
 protected:
  // gRPC's timers are used, so gRPC must outlive all replays, as in a server.
  static void SetUpTestSuite() { grpc_init(); }
  // A timer's thread may use the pool last, and the context must outlive the pool.
  void TearDown() override { destroyed_.WaitForNotification(); }

  // A pool before request 1, which an earlier process accepted.
  std::shared_ptr<PoolSession> Make(int32_t env_count, std::function<absl::Status()> next_error) {
    PoolOptions options;
    options.games = {"maze"};
    options.env_count = env_count;
    auto made = Pool::Create(options, std::make_shared<WorkerPool>(1));
    EXPECT_THAT(made, IsOk());
    auto pool = std::make_unique<SynchronousPool>(context_.Backend(*std::move(made)),
                                                  std::move(next_error), &destroyed_);
    pool_ = pool.get();
    auto session = std::make_shared<PoolSession>("", "pools/7", std::move(pool),
                                                 absl::InfiniteDuration(), context_.Get());
    session->ResumeAt(2);
    return session;
  }

  static std::vector<std::string> OneStep(int32_t env_count) {
    v1::StepPoolRequest request;
    request.set_sequence_number(1);
    request.mutable_step()->mutable_slice()->set_env_count(env_count);
    request.mutable_step()->mutable_actions()->Resize(env_count, 4);
    request.mutable_step()->set_repeat_count(1);
    request.mutable_step()->set_observation(v1::OBSERVATION_FRAME);
    return {request.SerializeAsString()};
  }

  // Takes a turn and ends it; returns its status.
  static absl::Status Turn(PoolSession* session) {
    absl::Notification begun;
    absl::Status turn;
    session->TakeTurn([&](absl::Status status) {
      turn = std::move(status);
      begun.Notify();
    });
    begun.WaitForNotification();
    if (turn.ok()) {
      session->EndTurn();
    }
    return turn;
  }

  static absl::Status Attach(PoolSession* session) {
    std::optional<absl::Status> attached;
    session->Attach(
        {}, [](StreamEnd /*why*/, const absl::Status& /*reason*/) {},
        [&](absl::Status status) { attached = std::move(status); });
    return attached.value_or(absl::UnknownError("it has not been answered"));
  }

  TestPoolContext context_;
  absl::Notification destroyed_;  // of the pool
  SynchronousPool* pool_ = nullptr;
};

TEST_F(ResumeReplayTest, ManyPartsTakeNoMoreStackThanOne) {
  constexpr int32_t kEnvCount = 1000;  // of 12 KiB each, in parts of 64 KiB
  const auto session = Make(kEnvCount, [] { return absl::OkStatus(); });
  StartResumeReplay(session, OneStep(kEnvCount), int64_t{64} << 20);
  EXPECT_THAT(Turn(session.get()), IsOk());
  EXPECT_EQ(session->oldest_kept_sequence_number(), 1);
  EXPECT_GE(pool_->part_count(), 200);
  EXPECT_LE(pool_->stack_bytes(), 4096);
}

class PermanentErrorTest : public ResumeReplayTest,
                           public testing::WithParamInterface<absl::StatusCode> {};

TEST_P(PermanentErrorTest, EndsTheReplayAndAnswersAttach) {
  const auto session = Make(2, [] { return absl::Status(GetParam(), "the node is of 1970"); });
  StartResumeReplay(session, OneStep(2), int64_t{64} << 20);
  const auto is_replay_error =
      StatusIs(GetParam(), "pool pools/7 could not be resumed: the node is of 1970");
  EXPECT_THAT(Turn(session.get()), is_replay_error);
  EXPECT_THAT(Attach(session.get()), is_replay_error);
  EXPECT_EQ(pool_->part_count(), 1);
}

INSTANTIATE_TEST_SUITE_P(
    Codes, PermanentErrorTest,
    testing::Values(absl::StatusCode::kInvalidArgument, absl::StatusCode::kDataLoss,
                    absl::StatusCode::kFailedPrecondition, absl::StatusCode::kUnimplemented,
                    absl::StatusCode::kInternal, absl::StatusCode::kOutOfRange));

TEST_F(ResumeReplayTest, OtherErrorsAreRetriedWithBackoff) {
  std::atomic<int> failures_left = 3;
  const auto session = Make(2, [&]() -> absl::Status {
    return failures_left-- > 0 ? absl::UnavailableError("there is no node") : absl::OkStatus();
  });
  const absl::Time begin = SteadyNow();
  StartResumeReplay(session, OneStep(2), int64_t{64} << 20);
  EXPECT_THAT(Turn(session.get()), IsOk());
  EXPECT_GE(SteadyNow() - begin, absl::Milliseconds(100 + 200 + 400));
  EXPECT_EQ(pool_->part_count(), 3 + 2) << "then the request and the state of all environments";
  EXPECT_EQ(session->oldest_kept_sequence_number(), 1);
}

TEST_F(ResumeReplayTest, ClosedPoolIsReleasedAtOnce) {
  absl::Notification failed;
  std::atomic<int> failure_count = 0;
  auto session = Make(2, [&]() -> absl::Status {
    if (++failure_count == 5) {
      failed.Notify();
    }
    return absl::UnavailableError("there is no node");
  });
  StartResumeReplay(session, OneStep(2), int64_t{64} << 20);
  failed.WaitForNotification();  // the next attempt is 1.6 s away
  const int count = failure_count;
  session->Close(absl::AbortedError("it was deleted"));
  session = nullptr;
  destroyed_.WaitForNotification();
  EXPECT_EQ(failure_count, count);
}

TEST_F(ResumeReplayTest, DrainDoesNotWaitForReplay) {
  absl::Notification failed;
  std::atomic<int> failure_count = 0;
  const auto session = Make(2, [&]() -> absl::Status {
    if (++failure_count == 5) {
      failed.Notify();
    }
    return absl::UnavailableError("there is no node");
  });
  StartResumeReplay(session, OneStep(2), int64_t{64} << 20);
  failed.WaitForNotification();
  const int count = failure_count;
  session->EndObservers(absl::UnavailableError("the server drains"));
  EXPECT_THAT(Turn(session.get()), IsOk());
  EXPECT_EQ(failure_count, count);
}

}  // namespace
}  // namespace procgen
