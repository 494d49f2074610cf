#include "server/session/pool/pool_session.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gtest/gtest.h"
#include "tests/server/session/test_pool_context.h"
#include "tests/server/session/test_sink.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int32_t kEnvCount = 4;

class PoolSessionTest : public testing::Test {
 protected:
  std::unique_ptr<PoolSession> Make(AutoresetMode autoreset_mode = AutoresetMode::kSameStep,
                                    absl::Duration lease = absl::InfiniteDuration()) {
    PoolOptions options;
    options.games = {"maze"};
    options.env_count = kEnvCount;
    options.autoreset_mode = autoreset_mode;
    absl::StatusOr<std::unique_ptr<Pool>> pool = Pool::Create(options, workers_);
    EXPECT_THAT(pool, IsOk());
    return std::make_unique<PoolSession>("", "pools/7", context_.Backend(*std::move(pool)), lease,
                                         context_.Get());
  }

  // Attaches to a pool without a stream.
  static absl::Status Attach(
      PoolSession* session, const AttachOptions& options = {},
      PoolSession::EndStream end_stream = [](StreamEnd, const absl::Status&) {}) {
    absl::Status result = absl::UnknownError("it waits");
    session->Attach(options, std::move(end_stream),
                    [&](absl::Status status) { result = std::move(status); });
    return result;
  }

  static std::string Save(PoolSession* session, int32_t environment) {
    std::string saved;
    absl::Notification done;
    session->TakeTurn([&](const absl::Status&) {
      session->SaveStates(
          {&environment, 1},
          [&](int32_t /*environment*/, std::string snapshot) {
            saved = std::move(snapshot);
            return true;
          },
          [&](const absl::Status&) { done.Notify(); });
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

  static Request StepOf(int64_t sequence_number, const std::vector<int32_t>& actions) {
    Request request = RequestOf(sequence_number);
    request.kind = Request::Kind::kStep;
    request.actions = actions;
    return request;
  }

  // A step of all environments, and its results.
  struct StepCall {
    explicit StepCall(int64_t sequence_number) : request(StepOf(sequence_number, actions)) {}

    std::vector<int32_t> actions = std::vector<int32_t>(kEnvCount, 4);
    Request request;
    std::shared_ptr<TestSink> sink = std::make_shared<TestSink>();
  };

  std::shared_ptr<WorkerPool> workers_ = std::make_shared<WorkerPool>(1);
  TestPoolContext context_;
};

TEST_F(PoolSessionTest, SecondStreamIsRejectedUntilTheFirstDetaches) {
  const std::unique_ptr<PoolSession> session = Make();
  ASSERT_THAT(Attach(session.get()), IsOk());
  EXPECT_THAT(Attach(session.get()),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "another stream is attached to pool pools/7, allowed: one at a time; end "
                       "that one, or attach with take_over"));
  session->Detach();
  EXPECT_THAT(Attach(session.get()), IsOk());
}

TEST_F(PoolSessionTest, CloseNotifiesTheStreamAndWaiters) {
  const std::unique_ptr<PoolSession> session = Make();
  absl::Status ended;
  absl::Status waited;
  ASSERT_THAT(Attach(session.get(), {},
                     [&](StreamEnd why, absl::Status reason) {
                       EXPECT_EQ(why, StreamEnd::kClosed);
                       ended = std::move(reason);
                     }),
              IsOk());
  session->TakeTurn([](const absl::Status&) {});
  session->TakeTurn([&](const absl::Status& status) { waited = status; });
  session->Close(absl::AbortedError("deleted"));
  EXPECT_THAT(ended, StatusIs(absl::StatusCode::kAborted, "deleted"));
  EXPECT_THAT(waited, StatusIs(absl::StatusCode::kAborted, "deleted"));
  session->Detach();
  EXPECT_THAT(Attach(session.get()), StatusIs(absl::StatusCode::kAborted, "deleted"));
  session->EndTurn();
}

TEST_F(PoolSessionTest, PausedPoolExecutesOneRequestPerStepAndItsStateCanBeSaved) {
  const std::unique_ptr<PoolSession> session = Make();
  ASSERT_THAT(Attach(session.get()), IsOk());
  session->Pause();
  StepCall first(1);
  session->Execute(&first.request, first.sink);
  EXPECT_EQ(session->step_count(), 0);
  const std::string before = Save(session.get(), 0);
  session->StepPaused();
  EXPECT_THAT(first.sink->status(), IsOk());
  EXPECT_NE(Save(session.get(), 0), before);

  StepCall second(2);
  session->Execute(&second.request, second.sink);
  EXPECT_EQ(session->step_count(), kEnvCount);
  session->EndPause();
  EXPECT_THAT(second.sink->status(), IsOk());
  EXPECT_EQ(session->step_count(), 2 * kEnvCount);
}

TEST_F(PoolSessionTest, DeletedPoolDoesNotKeepAPausedRequest) {
  const std::unique_ptr<PoolSession> session = Make();
  ASSERT_THAT(Attach(session.get()), IsOk());
  session->Pause();
  StepCall step(1);
  session->Execute(&step.request, step.sink);
  session->Close(absl::AbortedError("deleted"));
  EXPECT_THAT(step.sink->status(), StatusIs(absl::StatusCode::kAborted, "deleted"));
}

TEST_F(PoolSessionTest, StreamThatIsTakenOverEndsAPausedRequestAndTheNextWaits) {
  const std::unique_ptr<PoolSession> session = Make();
  ASSERT_THAT(Attach(session.get()), IsOk());
  session->Pause();
  StepCall step(1);
  session->Execute(&step.request, step.sink);
  absl::Status taken = absl::UnknownError("it waits");
  session->Attach(
      {.take_over = true}, [](StreamEnd, const absl::Status&) {},
      [&](absl::Status status) { taken = std::move(status); });
  EXPECT_THAT(step.sink->status(), IsOk());
  session->Detach();
  EXPECT_THAT(taken, IsOk());
  StepCall next(2);
  session->Execute(&next.request, next.sink);
  EXPECT_EQ(session->step_count(), kEnvCount);
  session->EndPause();
  EXPECT_THAT(next.sink->status(), IsOk());
}

TEST_F(PoolSessionTest, StreamAfterOneThatDetachesWhenItIsTakenOverWaits) {
  const std::unique_ptr<PoolSession> session = Make();
  ASSERT_THAT(Attach(session.get(), {}, [&](StreamEnd, const absl::Status&) { session->Detach(); }),
              IsOk());
  session->Pause();
  EXPECT_THAT(Attach(session.get(), {.take_over = true}), IsOk());
  StepCall step(1);
  session->Execute(&step.request, step.sink);
  EXPECT_EQ(session->next_sequence_number(), 1);
  session->EndPause();
  EXPECT_THAT(step.sink->status(), IsOk());
}

TEST_F(PoolSessionTest, OnlyAcceptedRequestsTakeASequenceNumber) {
  const std::unique_ptr<PoolSession> session = Make();
  const std::vector<int32_t> actions(kEnvCount, 4);
  const std::vector<int32_t> wrong_actions(kEnvCount, 15);
  EXPECT_THAT(Execute(session.get(), StepOf(1, wrong_actions)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("actions[0] is 15")));
  EXPECT_EQ(session->next_sequence_number(), 1);
  EXPECT_THAT(Execute(session.get(), StepOf(1, actions)), IsOk());
  EXPECT_EQ(session->next_sequence_number(), 2);
  EXPECT_EQ(context_.step_count, kEnvCount);
}

TEST_F(PoolSessionTest, SequenceNumbersMustBeConsecutive) {
  const std::unique_ptr<PoolSession> session = Make();
  const std::vector<int32_t> actions(kEnvCount, 4);
  for (const int64_t number : {int64_t{-1}, int64_t{0}, int64_t{2}, INT64_MAX}) {
    EXPECT_THAT(Execute(session.get(), StepOf(number, actions)),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         "sequence_number is " + std::to_string(number) +
                             ", allowed: 1, the next of pool pools/7"));
  }
}

TEST_F(PoolSessionTest, EndedEnvironmentNeedsAResetWithoutAutoreset) {
  const std::unique_ptr<PoolSession> session = Make(AutoresetMode::kDisabled);
  const std::vector<int32_t> actions(kEnvCount, 4);
  const std::vector<int32_t> ending = {4, -1, 4, 4};
  ASSERT_THAT(Execute(session.get(), StepOf(1, ending)), IsOk());
  EXPECT_THAT(Execute(session.get(), StepOf(2, actions)),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       "the episode of environment 1 of pool pools/7 has ended; reset it before it "
                       "is stepped"));
  Request step = StepOf(2, actions);
  const std::vector<Reset> resets = {{1, {}, {}}};
  step.resets = resets;
  EXPECT_THAT(Execute(session.get(), step), IsOk());
  EXPECT_THAT(Execute(session.get(), StepOf(3, actions)), IsOk());
}

TEST_F(PoolSessionTest, SavingStopsOnRequest) {
  const std::unique_ptr<PoolSession> session = Make();
  std::vector<int32_t> taken;
  const std::vector<int32_t> environments = {3, 1, 0};
  absl::Notification done;
  session->TakeTurn([&](const absl::Status&) {
    session->SaveStates(
        environments,
        [&](int32_t environment, const std::string& snapshot) {
          EXPECT_NE(snapshot, "");
          taken.push_back(environment);
          return taken.size() < 2;
        },
        [&](const absl::Status& status) {
          EXPECT_THAT(status, IsOk());
          done.Notify();
        });
  });
  done.WaitForNotification();
  session->EndTurn();
  EXPECT_THAT(taken, ElementsAre(3, 1));
}

TEST_F(PoolSessionTest, OnlyStepsAndRestoresChangeTheChangeNumber) {
  const std::unique_ptr<PoolSession> session = Make();
  const std::vector<int32_t> actions(kEnvCount, 4);
  const int64_t made = session->change_number();
  ASSERT_THAT(Execute(session.get(), StepOf(1, actions)), IsOk());
  const int64_t stepped = session->change_number();
  EXPECT_NE(stepped, made);
  Request observe;
  observe.sequence_number = 2;
  ASSERT_THAT(Execute(session.get(), observe), IsOk());
  EXPECT_EQ(session->change_number(), stepped);
  EXPECT_THAT(Restore(session.get(), 0, Save(session.get(), 1)), IsOk());
  EXPECT_NE(session->change_number(), stepped);
}

TEST_F(PoolSessionTest, StateIncludesThePendingReset) {
  const std::unique_ptr<PoolSession> session = Make(AutoresetMode::kDisabled);
  const std::vector<int32_t> actions(kEnvCount, 4);
  const std::vector<int32_t> ending = {4, -1, 4, 4};
  const std::string running = Save(session.get(), 1);
  ASSERT_THAT(Execute(session.get(), StepOf(1, ending)), IsOk());
  const std::string ended = Save(session.get(), 1);
  ASSERT_THAT(Restore(session.get(), 1, running), IsOk());
  EXPECT_THAT(Execute(session.get(), StepOf(2, actions)), IsOk());
  ASSERT_THAT(Restore(session.get(), 3, ended), IsOk());
  EXPECT_THAT(Execute(session.get(), StepOf(3, actions)),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("environment 3")));
}

TEST_F(PoolSessionTest, ResetAffectsOnlyItsEnvironments) {
  const std::unique_ptr<PoolSession> session = Make();
  const std::vector<int32_t> actions(kEnvCount, 4);
  ASSERT_THAT(Execute(session.get(), StepOf(1, actions)), IsOk());
  std::vector<int32_t> lengths(kEnvCount);
  std::vector<int32_t> level_seeds(kEnvCount);
  std::vector<uint8_t> first(kEnvCount);
  Batch batch;
  batch.episode_lengths = absl::MakeSpan(lengths);
  batch.level_seeds = absl::MakeSpan(level_seeds);
  batch.first = absl::MakeSpan(first);
  const std::vector<Reset> resets = {{3, 77, {}}, {0, {}, {}}, {2, 55, {}}};
  Request reset;
  reset.sequence_number = 2;
  reset.kind = Request::Kind::kReset;
  reset.resets = resets;
  ASSERT_THAT(Execute(session.get(), reset, batch), IsOk());
  EXPECT_THAT(lengths, ElementsAre(0, 1, 0, 0));
  EXPECT_THAT(first, ElementsAre(1, 0, 1, 1));
  EXPECT_EQ(level_seeds[2], 55);
  EXPECT_EQ(level_seeds[3], 77);
}

}  // namespace
}  // namespace procgen
