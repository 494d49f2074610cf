#include "server/pool/pool_session.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/server/pool/test_pool_context.h"
#include "tests/server/pool/test_sink.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int32_t kEnvCount = 4;

// Counts what it observes.
struct CountingObserver final : PoolObserver {
  void OnExecuted(const Request& /*request*/, const StepInput& /*input*/, const Batch& batch,
                  int64_t request_count, int64_t /*change_number*/) override {
    last_request = request_count;
    rewards_size = batch.rewards.size();
  }
  void OnInvalidated() override { ++invalidated; }
  void OnEnd(const absl::Status& reason) override { end = reason; }

  int64_t last_request = 0;
  size_t rewards_size = 0;
  int invalidated = 0;
  absl::Status end;
};

class PoolSessionTest : public testing::Test {
 protected:
  std::unique_ptr<PoolSession> Make(PoolSession::EndStream end_stream = [](const absl::Status&) {
  }) {
    PoolOptions options;
    options.games = {"maze"};
    options.env_count = kEnvCount;
    absl::StatusOr<std::unique_ptr<Pool>> pool = Pool::Create(options, workers_);
    EXPECT_THAT(pool, IsOk());
    return std::make_unique<PoolSession>("", "pools/7", *std::move(pool), SessionOptions(),
                                         std::move(end_stream), context_.Get());
  }

  static std::string Save(PoolSession* session, int32_t environment) {
    std::string saved;
    absl::Notification done;
    session->TakeTurn([&](const absl::Status&) {
      session->SaveStates({&environment, 1},
                          [&](absl::StatusOr<std::vector<std::string>> snapshots) {
                            EXPECT_THAT(snapshots, IsOk());
                            saved = std::move(snapshots->front());
                            done.Notify();
                          });
    });
    done.WaitForNotification();
    session->EndTurn();
    return saved;
  }

  static absl::Status Restore(PoolSession* session, int32_t environment,
                              const std::string& snapshot) {
    absl::Status result;
    absl::Notification done;
    session->TakeTurn([&](const absl::Status&) {
      session->RestoreStates({{environment, snapshot}}, [&](absl::Status status) {
        result = std::move(status);
        done.Notify();
      });
    });
    done.WaitForNotification();
    session->EndTurn();
    return result;
  }

  static Request StepOf(const std::vector<int32_t>& actions) {
    Request request = RequestOf(Request::Kind::kStep, kEnvCount);
    request.actions = actions;
    return request;
  }

  // A step of all environments, and its results.
  struct StepCall {
    std::vector<int32_t> actions = std::vector<int32_t>(kEnvCount, 4);
    Request request = StepOf(actions);
    std::shared_ptr<TestSink> sink = std::make_shared<TestSink>();
  };

  std::shared_ptr<WorkerPool> workers_ = std::make_shared<WorkerPool>(1);
  TestPoolContext context_;
};

TEST_F(PoolSessionTest, EndAsksTheStreamOnceAndCloseEndsObserversAndWaiters) {
  std::vector<absl::Status> ends;
  const std::unique_ptr<PoolSession> session =
      Make([&](const absl::Status& reason) { ends.push_back(reason); });
  const auto observer = std::make_shared<CountingObserver>();
  ASSERT_THAT(session->AddObserver(observer), IsOk());
  absl::Status waited = absl::UnknownError("it waits");
  session->TakeTurn([](const absl::Status&) {});
  session->TakeTurn([&](const absl::Status& status) { waited = status; });
  session->End(absl::UnavailableError("drains"));
  session->End(absl::UnknownError("again"));
  EXPECT_THAT(waited, StatusIs(absl::StatusCode::kUnknown, "it waits"));
  EXPECT_THAT(observer->end, IsOk());
  session->Close(absl::AbortedError("freed"));
  EXPECT_THAT(ends, ElementsAre(StatusIs(absl::StatusCode::kUnavailable, "drains")));
  EXPECT_THAT(waited, StatusIs(absl::StatusCode::kAborted, "freed"));
  EXPECT_THAT(observer->end, StatusIs(absl::StatusCode::kAborted, "freed"));
  EXPECT_THAT(session->AddObserver(observer), StatusIs(absl::StatusCode::kAborted, "freed"));
  session->EndTurn();
}

TEST_F(PoolSessionTest, PausedPoolExecutesOneRequestPerStepAndItsStateCanBeSaved) {
  const std::unique_ptr<PoolSession> session = Make();
  session->Pause();
  StepCall first;
  session->Execute(&first.request, first.sink);
  EXPECT_EQ(session->step_count(), 0);
  const std::string before = Save(session.get(), 0);
  session->StepPaused();
  EXPECT_THAT(first.sink->status(), IsOk());
  EXPECT_NE(Save(session.get(), 0), before);

  StepCall second;
  session->Execute(&second.request, second.sink);
  EXPECT_EQ(session->step_count(), kEnvCount);
  session->EndPause();
  EXPECT_THAT(second.sink->status(), IsOk());
  EXPECT_EQ(session->step_count(), 2 * kEnvCount);
}

TEST_F(PoolSessionTest, EndExecutesAPausedRequestAndCloseRejectsIt) {
  for (const bool closes : {false, true}) {
    const std::unique_ptr<PoolSession> session = Make();
    session->Pause();
    StepCall step;
    session->Execute(&step.request, step.sink);
    EXPECT_FALSE(step.sink->is_done());
    if (closes) {
      session->Close(absl::AbortedError("freed"));
      EXPECT_THAT(step.sink->status(), StatusIs(absl::StatusCode::kAborted, "freed"));
    } else {
      session->End(absl::UnavailableError("drains"));
      EXPECT_THAT(step.sink->status(), IsOk());
    }
  }
}

TEST_F(PoolSessionTest, RejectedRequestsChangeNothingAndEndTheirTurn) {
  const std::unique_ptr<PoolSession> session = Make();
  const std::vector<int32_t> actions(kEnvCount, 4);
  const std::vector<int32_t> wrong_actions(kEnvCount, 15);
  const int64_t change_number = session->change_number();
  EXPECT_THAT(Execute(session.get(), StepOf(wrong_actions)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("actions[0] is 15")));
  EXPECT_EQ(session->request_count(), 0);
  EXPECT_EQ(session->request_times().count, 0);
  EXPECT_EQ(session->change_number(), change_number);
  EXPECT_THAT(Execute(session.get(), StepOf(actions)), IsOk());
  EXPECT_EQ(session->request_count(), 1);
  EXPECT_EQ(session->request_times().count, 1);
  EXPECT_EQ(context_.step_count, kEnvCount);
}

TEST_F(PoolSessionTest, ObserversSeeValuesThatTheLearnerDoesNotAskFor) {
  const std::unique_ptr<PoolSession> session = Make();
  const auto observer = std::make_shared<CountingObserver>();
  ASSERT_THAT(session->AddObserver(observer), IsOk());
  StepCall step;
  session->Execute(&step.request, step.sink);
  ASSERT_THAT(step.sink->status(), IsOk());
  EXPECT_EQ(observer->last_request, 1);
  EXPECT_EQ(observer->rewards_size, kEnvCount);
  EXPECT_EQ(observer->invalidated, 0);
  ASSERT_THAT(Restore(session.get(), 0, Save(session.get(), 1)), IsOk());
  EXPECT_EQ(observer->invalidated, 1);
  session->RemoveObserver(observer.get());
  ASSERT_THAT(Execute(session.get(), step.request), IsOk());
  EXPECT_EQ(observer->last_request, 1);
}

}  // namespace
}  // namespace procgen
