// Broken, resumed and taken-over streams of a pool, and its lease.

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/session/pool/pool_session.h"
#include "tests/server/session/test_pool_context.h"
#include "tests/server/session/test_sink.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int32_t kEnvCount = 2;
const AttachOptions kResumable = {.requests_in_flight_max = 2, .resumable = true};

// Records the callbacks of a stream.
struct Stream {
  void Attach(PoolSession* session, const AttachOptions& options) {
    session->Attach(
        options,
        [this](StreamEnd why, absl::Status reason) {
          end = why;
          ended = std::move(reason);
        },
        [this](absl::Status status) { attached = std::move(status); });
  }

  std::optional<absl::Status> attached;
  std::optional<absl::Status> ended;
  std::optional<StreamEnd> end;
};

class ResumedSessionTest : public testing::Test {
 protected:
  std::unique_ptr<PoolSession> Make(absl::Duration lease = absl::InfiniteDuration()) {
    return Make(&context_, lease);
  }

  static std::unique_ptr<PoolSession> Make(TestPoolContext* context, absl::Duration lease,
                                           Encoding encoding = Encoding::kRaw) {
    PoolOptions options;
    options.games = {"maze"};
    options.env_count = kEnvCount;
    absl::StatusOr<std::unique_ptr<Pool>> pool =
        Pool::Create(options, std::make_shared<WorkerPool>(1));
    EXPECT_THAT(pool, IsOk());
    return std::make_unique<PoolSession>("", "pools/7", context->Backend(*std::move(pool)), lease,
                                         context->Get(), encoding);
  }

  // Executes request `number`. Returns the kept answer if it was executed before.
  absl::StatusOr<std::optional<Answer>> Ask(int64_t number, int64_t acknowledged = 0) {
    Request request = RequestOf(number);
    request.acknowledged = acknowledged;
    const auto sink = std::make_shared<TestSink>(Batch(), "answer to " + std::to_string(number));
    session_->Execute(&request, sink);
    if (!sink->status().ok()) {
      return sink->status();
    }
    return sink->recalled();
  }

  void Attach(const AttachOptions& options) {
    Stream stream;
    stream.Attach(session_.get(), options);
    EXPECT_THAT(stream.attached, testing::Optional(IsOk()));
  }

  TestPoolContext context_;
  std::unique_ptr<PoolSession> session_ = Make();
};

TEST_F(ResumedSessionTest, RepeatedRequestIsAnsweredFromTheBuffer) {
  Attach(kResumable);
  ASSERT_THAT(Ask(1), IsOk());
  session_->Detach();
  Attach(kResumable);
  EXPECT_EQ(session_->oldest_kept_sequence_number(), 1);
  const auto again = Ask(1);
  ASSERT_THAT(again, IsOk());
  ASSERT_TRUE(again->has_value());
  EXPECT_THAT(**again, ElementsAre("answer to 1"));
  EXPECT_EQ(session_->next_sequence_number(), 2);
}

TEST_F(ResumedSessionTest, KeptResponsesAreBoundedByTheWindow) {
  Attach(kResumable);
  for (const int64_t number : {1, 2, 3, 4}) {
    ASSERT_THAT(Ask(number), IsOk());
  }
  EXPECT_EQ(session_->oldest_kept_sequence_number(), 3);
  EXPECT_THAT(Ask(2),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "sequence_number is 2, which pool pools/7 has carried out before and whose "
                       "answer is not kept; kept: 3 to 4, the next: 5"));
  EXPECT_THAT(Ask(3), IsOk());
}

TEST_F(ResumedSessionTest, AcknowledgedResponsesAreDropped) {
  Attach(kResumable);
  ASSERT_THAT(Ask(1), IsOk());
  ASSERT_THAT(Ask(2, /*acknowledged=*/1), IsOk());
  EXPECT_EQ(session_->oldest_kept_sequence_number(), 2);
  EXPECT_THAT(Ask(1), StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("kept: 2 to 2")));
}

TEST_F(ResumedSessionTest, OnlyEarlierRequestsCanBeAcknowledged) {
  Attach(kResumable);
  for (const int64_t acknowledged : {int64_t{-1}, int64_t{1}, INT64_MAX}) {
    EXPECT_THAT(Ask(1, acknowledged), StatusIs(absl::StatusCode::kInvalidArgument,
                                               HasSubstr("with request 1, allowed: 0 to 0")));
  }
  EXPECT_EQ(session_->next_sequence_number(), 1);
}

TEST_F(ResumedSessionTest, NonResumableStreamDropsAll) {
  Attach(kResumable);
  ASSERT_THAT(Ask(1), IsOk());
  EXPECT_GT(context_.resume_buffer_bytes.reserved_bytes(), 0);
  session_->Detach();
  Attach({});
  EXPECT_EQ(session_->oldest_kept_sequence_number(), 2);
  EXPECT_EQ(context_.resume_buffer_bytes.reserved_bytes(), 0);
  EXPECT_THAT(Ask(1), StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("kept: none")));
}

TEST_F(ResumedSessionTest, ResumeBufferIsReservedOnceAndReturned) {
  Attach(kResumable);
  const int64_t bytes = context_.resume_buffer_bytes.reserved_bytes();
  EXPECT_EQ(bytes, 2 * kEnvCount * (2 * 12288 + 512));
  session_->Detach();
  Attach(kResumable);
  EXPECT_EQ(context_.resume_buffer_bytes.reserved_bytes(), bytes);
  session_ = nullptr;
  EXPECT_EQ(context_.resume_buffer_bytes.reserved_bytes(), 0);
}

TEST_F(ResumedSessionTest, ResumeBufferFollowsTheWindowOfTheStream) {
  constexpr int64_t kAnswerBytes = kEnvCount * (2 * 12288 + 512);
  const ByteBudget& bytes = context_.resume_buffer_bytes;
  Attach({.requests_in_flight_max = 8, .resumable = true});
  EXPECT_EQ(bytes.reserved_bytes(), 8 * kAnswerBytes);
  for (const int64_t number : {1, 2, 3}) {
    ASSERT_THAT(Ask(number), IsOk());
  }
  session_->Detach();
  Attach({.requests_in_flight_max = 2, .resumable = true});
  EXPECT_EQ(bytes.reserved_bytes(), 3 * kAnswerBytes) << "three answers are kept";
  EXPECT_THAT(Ask(1), IsOk());
  ASSERT_THAT(Ask(4), IsOk());
  EXPECT_EQ(bytes.reserved_bytes(), 2 * kAnswerBytes);
  session_->Detach();
  Stream stream;
  stream.Attach(session_.get(), {.requests_in_flight_max = 4, .resumable = true});
  EXPECT_EQ(bytes.reserved_bytes(), 4 * kAnswerBytes);
  // During a takeover the larger window counts; afterwards the new one.
  Stream successor;
  successor.Attach(session_.get(),
                   {.requests_in_flight_max = 6, .resumable = true, .take_over = true});
  EXPECT_EQ(bytes.reserved_bytes(), 6 * kAnswerBytes);
  ASSERT_THAT(Ask(5), IsOk());
  EXPECT_EQ(bytes.reserved_bytes(), 6 * kAnswerBytes);
  session_->Detach();
  session_->Detach();
  Attach({.requests_in_flight_max = 1, .resumable = true});
  ASSERT_THAT(Ask(6, /*acknowledged=*/5), IsOk());
  EXPECT_EQ(bytes.reserved_bytes(), kAnswerBytes);
}

TEST_F(ResumedSessionTest, ResumeBufferCoversIncompressibleObservations) {
  session_ = Make(&context_, absl::InfiniteDuration(), Encoding::kDeltaZstd);
  Attach(kResumable);
  EXPECT_EQ(context_.resume_buffer_bytes.reserved_bytes(),
            2 * kEnvCount * (session_->coding().sent_bytes_max() + 12288 + 512));
}

TEST_F(ResumedSessionTest, StreamWithoutResumeBufferSpaceIsRejected) {
  ASSERT_TRUE(context_.resume_buffer_bytes.Change(0, (1 << 30) - 100'000));
  Stream stream;
  stream.Attach(session_.get(), kResumable);
  EXPECT_THAT(stream.attached,
              testing::Optional(StatusIs(
                  absl::StatusCode::kResourceExhausted,
                  "attach.resumable keeps 2 answers of up to 50176 bytes, and other pools have "
                  "1073641824, limit resume_buffer_bytes_max is 1073741824")));
  EXPECT_FALSE(session_->attached());
  Attach({});
}

TEST_F(ResumedSessionTest, TakeoverWaitsForTheOldStreamToDetach) {
  Stream first;
  Stream second;
  first.Attach(session_.get(), {});
  second.Attach(session_.get(), {.take_over = true});
  EXPECT_THAT(first.ended, testing::Optional(StatusIs(absl::StatusCode::kAborted,
                                                      "another stream took over pool pools/7")));
  EXPECT_EQ(first.end, StreamEnd::kTakenOver);
  EXPECT_FALSE(second.attached.has_value());
  session_->Detach();
  EXPECT_THAT(second.attached, testing::Optional(IsOk()));
  EXPECT_TRUE(session_->attached());
  EXPECT_FALSE(second.ended.has_value());
}

TEST_F(ResumedSessionTest, LastTakeoverWins) {
  Stream first;
  Stream second;
  Stream third;
  first.Attach(session_.get(), {});
  second.Attach(session_.get(), {.take_over = true});
  third.Attach(session_.get(), {.take_over = true});
  EXPECT_THAT(second.attached, testing::Optional(StatusIs(absl::StatusCode::kAborted, testing::_)));
  session_->Detach();
  EXPECT_THAT(third.attached, testing::Optional(IsOk()));
  EXPECT_FALSE(second.ended.has_value());
}

TEST_F(ResumedSessionTest, TakeoverInheritsTheReservation) {
  Limits limits;
  limits.owner_stream_count_max = 1;
  TestPoolContext context(limits);
  const auto session = Make(&context, absl::InfiniteDuration());
  const auto other = Make(&context, absl::InfiniteDuration());
  Stream first;
  Stream second;
  Stream of_other;
  first.Attach(session.get(), kResumable);
  second.Attach(session.get(), {.resumable = true, .take_over = true});
  session->Detach();
  EXPECT_THAT(second.attached, testing::Optional(IsOk()));
  of_other.Attach(other.get(), kResumable);
  EXPECT_THAT(of_other.attached, testing::Optional(StatusIs(absl::StatusCode::kResourceExhausted,
                                                            HasSubstr("owner_stream_count_max"))));
  session->Detach();
  of_other.Attach(other.get(), kResumable);
  EXPECT_THAT(of_other.attached, testing::Optional(IsOk()));
  other->Detach();
}

TEST_F(ResumedSessionTest, TakeoverOfAFreePoolIsAnAttach) { Attach({.take_over = true}); }

TEST_F(ResumedSessionTest, WaitingTakeoverEndsWhenThePoolCloses) {
  Stream first;
  Stream second;
  first.Attach(session_.get(), {});
  second.Attach(session_.get(), {.take_over = true});
  session_->Close(absl::AbortedError("deleted"));
  EXPECT_THAT(second.attached, testing::Optional(StatusIs(absl::StatusCode::kAborted, "deleted")));
  session_->Detach();
  EXPECT_FALSE(session_->attached());
}

TEST_F(ResumedSessionTest, LeaseRunsWhileNoStreamIsAttached) {
  session_ = Make(absl::Seconds(10));
  TestClock& clock = context_.clock;
  EXPECT_EQ(session_->expire_time(), clock.Now() + absl::Seconds(10));
  clock.Advance(absl::Seconds(5));
  Attach({});
  EXPECT_EQ(session_->expire_time(), absl::InfiniteFuture());
  clock.Advance(absl::Hours(5));
  EXPECT_FALSE(session_->CloseIfExpired(clock.Now()));
  session_->Detach();
  EXPECT_EQ(session_->expire_time(), clock.Now() + absl::Seconds(10));
  clock.Advance(absl::Seconds(10));
  EXPECT_TRUE(session_->CloseIfExpired(clock.Now()));
}

TEST_F(ResumedSessionTest, TakeoverDoesNotStartTheLease) {
  session_ = Make(absl::Seconds(10));
  Stream first;
  Stream second;
  first.Attach(session_.get(), {});
  second.Attach(session_.get(), {.take_over = true});
  session_->Detach();
  EXPECT_EQ(session_->expire_time(), absl::InfiniteFuture());
}

TEST_F(ResumedSessionTest, RenewalRestartsTheLease) {
  session_ = Make(absl::Seconds(10));
  TestClock& clock = context_.clock;
  clock.Advance(absl::Seconds(9));
  ASSERT_THAT(session_->Renew(std::nullopt), IsOk());
  EXPECT_EQ(session_->expire_time(), clock.Now() + absl::Seconds(10));
  ASSERT_THAT(session_->Renew(absl::Seconds(60)), IsOk());
  EXPECT_EQ(session_->expire_time(), clock.Now() + absl::Seconds(60));
  EXPECT_EQ(session_->lease_duration(), absl::Seconds(60));
}

TEST_F(ResumedSessionTest, RenewalWhileAttachedChangesOnlyTheDuration) {
  session_ = Make(absl::Seconds(10));
  Attach({});
  ASSERT_THAT(session_->Renew(absl::Seconds(60)), IsOk());
  EXPECT_EQ(session_->expire_time(), absl::InfiniteFuture());
  session_->Detach();
  EXPECT_EQ(session_->expire_time(), context_.clock.Now() + absl::Seconds(60));
}

}  // namespace
}  // namespace procgen
