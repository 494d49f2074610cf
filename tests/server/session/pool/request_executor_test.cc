#include "server/session/pool/request_executor.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/session/pool/batch_sink.h"
#include "tests/server/session/test_pool_context.h"
#include "tests/server/session/test_sink.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int32_t kEnvCount = 7;

// A sink without memory for a part until is_free is set.
class LateSink final : public ResponseSink {
 public:
  absl::StatusOr<std::optional<Batch>> PreparePart(Part /*part*/) override {
    ++asked;
    if (!is_free) {
      return std::nullopt;
    }
    is_free = false;
    return Batch();
  }
  void Flush() override { ++flushed; }
  absl::Cord PartDone(Part part, bool /*keep*/) override {
    parts.push_back(part.count);
    return {};
  }
  absl::Status Recall(const Answer& /*answer*/) override { return absl::OkStatus(); }
  void Done(const absl::Status& status) override { done = status; }

  bool is_free = false;
  int asked = 0;
  int flushed = 0;
  std::vector<int32_t> parts;
  std::optional<absl::Status> done;
};

class RequestExecutorTest : public testing::Test {
 protected:
  std::shared_ptr<PoolSession> Make(int32_t env_count) {
    PoolOptions options;
    options.games = {"maze"};
    options.env_count = env_count;
    absl::StatusOr<std::unique_ptr<Pool>> pool =
        Pool::Create(options, std::make_shared<WorkerPool>(1));
    EXPECT_THAT(pool, IsOk());
    return std::make_shared<PoolSession>("", "pools/7", context_.Backend(*std::move(pool)),
                                         absl::InfiniteDuration(), context_.Get());
  }

  static std::vector<int32_t> PartsOf(const std::vector<Part>& parts) {
    std::vector<int32_t> counts;
    counts.reserve(parts.size());
    for (const Part part : parts) {
      counts.push_back(part.count);
    }
    return counts;
  }

  TestPoolContext context_;
};

TEST_F(RequestExecutorTest, RequestHasAtLeastTheRequestedChunks) {
  const auto session = Make(kEnvCount);
  Request request;
  request.sequence_number = 1;
  request.chunk_count = 3;
  const auto sink = std::make_shared<TestSink>();
  session->Execute(&request, sink);
  ASSERT_THAT(sink->status(), IsOk());
  EXPECT_THAT(PartsOf(sink->parts()), ElementsAre(3, 2, 2));
}

TEST_F(RequestExecutorTest, NoPartExceedsOneResponse) {
  const auto session = Make(kEnvCount);
  Request request;
  request.sequence_number = 1;
  request.chunk_rows_max = 2;
  const auto sink = std::make_shared<TestSink>();
  session->Execute(&request, sink);
  ASSERT_THAT(sink->status(), IsOk());
  EXPECT_THAT(PartsOf(sink->parts()), ElementsAre(2, 2, 2, 1));
}

TEST_F(RequestExecutorTest, APartWaitsUntilItsSinkHasMemory) {
  const auto session = Make(1);
  Request request;
  request.sequence_number = 1;
  const auto sink = std::make_shared<LateSink>();
  session->Execute(&request, sink);
  EXPECT_EQ(sink->asked, 1);
  EXPECT_EQ(sink->flushed, 1) << "finished parts are sent, which frees memory";
  session->Resume();
  EXPECT_EQ(sink->asked, 2);
  EXPECT_EQ(sink->done, std::nullopt);
  sink->is_free = true;
  session->Resume();
  EXPECT_THAT(sink->done, testing::Optional(IsOk()));
  EXPECT_THAT(sink->parts, ElementsAre(1));
}

TEST_F(RequestExecutorTest, TheTurnEndsWithTheRequest) {
  const auto session = Make(1);
  Request request;
  request.sequence_number = 2;
  const auto sink = std::make_shared<TestSink>();
  session->Execute(&request, sink);
  EXPECT_THAT(sink->status(),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("allowed: 1")));
  bool has_turn = false;
  session->TakeTurn([&](const absl::Status& turn) { has_turn = turn.ok(); });
  EXPECT_TRUE(has_turn);
  session->EndTurn();
}

TEST_F(RequestExecutorTest, CancelledRequestIsNotExecutedOnItsTurn) {
  class Unwanted final : public ResponseSink {
   public:
    bool IsWanted() override { return false; }
    absl::StatusOr<std::optional<Batch>> PreparePart(Part /*part*/) override { return Batch(); }
    absl::Cord PartDone(Part /*part*/, bool /*keep*/) override { return {}; }
    absl::Status Recall(const Answer& /*answer*/) override { return absl::OkStatus(); }
    void Done(const absl::Status& status) override { done = status; }

    std::optional<absl::Status> done;
  };
  const auto session = Make(1);
  Request request;
  request.sequence_number = 1;
  const auto sink = std::make_shared<Unwanted>();
  session->Execute(&request, sink);
  EXPECT_THAT(sink->done, testing::Optional(StatusIs(absl::StatusCode::kCancelled, "")));
  EXPECT_EQ(session->next_sequence_number(), 1);
}

TEST_F(RequestExecutorTest, ResponseIsKeptAfterItsRequestIsDestroyed) {
  class RequestDestroyingSink final : public ResponseSink {
   public:
    absl::StatusOr<std::optional<Batch>> PreparePart(Part /*part*/) override { return Batch(); }
    absl::Cord PartDone(Part /*part*/, bool keep) override {
      EXPECT_TRUE(keep);
      request = Request();  // as if the next request was read meanwhile
      return absl::Cord("answer");
    }
    absl::Status Recall(const Answer& /*answer*/) override { return absl::OkStatus(); }
    void Done(const absl::Status& status) override {
      EXPECT_THAT(status, IsOk());
      done.Notify();
    }

    Request request;
    absl::Notification done;
  };
  const auto session = Make(kEnvCount);
  session->Attach(
      {.resumable = true}, [](StreamEnd, const absl::Status&) {},
      [](const absl::Status& status) { EXPECT_THAT(status, IsOk()); });
  const auto sink = std::make_shared<RequestDestroyingSink>();
  sink->request.sequence_number = 1;
  session->Execute(&sink->request, sink);
  sink->done.WaitForNotification();
  EXPECT_EQ(session->oldest_kept_sequence_number(), 1);
  session->Detach();
}

// Executes requests in one turn, each when the previous one is done.
class Series final : public ResponseSink, public std::enable_shared_from_this<Series> {
 public:
  Series(std::shared_ptr<PoolSession> session, int count)
      : session_(std::move(session)), left_(count) {}

  void Next() {
    request_ = Request();
    session_->ExecuteInTurn(&request_, shared_from_this());
  }
  absl::StatusOr<std::optional<Batch>> PreparePart(Part /*part*/) override { return Batch(); }
  absl::Cord PartDone(Part /*part*/, bool /*keep*/) override { return {}; }
  absl::Status Recall(const Answer& /*answer*/) override { return absl::OkStatus(); }
  void Done(const absl::Status& status) override {
    EXPECT_THAT(status, IsOk());
    if (--left_ > 0) {
      Next();
    } else {
      session_->EndTurn();
      done.Notify();
    }
  }

  absl::Notification done;

 private:
  const std::shared_ptr<PoolSession> session_;
  Request request_;
  int left_;
};

TEST_F(RequestExecutorTest, ConsecutiveRequestsDoNotNestOnTheStack) {
  const auto session = Make(1);  // a single environment is observed on this thread
  const auto series = std::make_shared<Series>(session, 50000);
  session->TakeTurn([&](const absl::Status& turn) {
    ASSERT_THAT(turn, IsOk());
    series->Next();
  });
  series->done.WaitForNotification();
}

}  // namespace
}  // namespace procgen
