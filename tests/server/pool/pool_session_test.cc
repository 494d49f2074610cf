#include "server/pool/pool_session.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/server/pool/test_pool_context.h"
#include "tests/server/pool/test_sink.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;

constexpr int32_t kEnvCount = 4;

// Keeps how its pool has ended.
struct EndObserver final : PoolObserver {
  void OnExecuted(const Request& /*request*/, const StepInput& /*input*/, const Batch& /*batch*/,
                  int64_t /*request_count*/, int64_t /*change_number*/) override {}
  void OnInvalidated() override {}
  void OnEnd(const absl::Status& reason) override { end = reason; }

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
  const auto observer = std::make_shared<EndObserver>();
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

}  // namespace
}  // namespace procgen
