// Saving and restoring over gRPC: a restored environment continues like an uninterrupted one.

#include <string>
#include <vector>

#include "envcore/pool/pool.h"
#include "envcore/random/random_stream.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"
#include "tests/service/stream/batch_copy.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

constexpr int32_t kSavedCount = 3;
constexpr int32_t kOtherCount = 5;
constexpr int kStepsAfter = 40;

// Random actions for the first `count` environments; one in 20 ends the episode.
v1::StepPoolRequest RandomStep(RandomStream* random, int32_t count) {
  v1::StepPoolRequest request = SliceStepRequest(0, count, 0);
  for (int32_t& action : *request.mutable_step()->mutable_actions()) {
    action = random->Int(kActionCount);
    if (random->Int(20) == 0) {
      action = kEndEpisodeAction;
    }
  }
  request.mutable_step()->set_with_final_observations(true);
  return request;
}

// Batches of the first `count` environments: of an observe, then of each of `steps` random steps.
std::vector<BatchCopy> Played(procgen_client::StepStream* stream, int64_t seed, int32_t count,
                              int steps) {
  RandomStream random(seed);
  std::vector<BatchCopy> played;
  procgen_client::Batch batch;
  v1::StepPoolRequest observe;
  observe.mutable_observe()->mutable_slice()->set_env_count(count);
  EXPECT_THAT(stream->Call(observe, &batch), IsOk());
  played.emplace_back(batch);
  for (int step = 0; step < steps; ++step) {
    EXPECT_THAT(stream->Call(RandomStep(&random, count), &batch), IsOk());
    played.emplace_back(batch);
  }
  return played;
}

std::vector<std::string> SnapshotsOf(const std::vector<v1::State>& states) {
  std::vector<std::string> snapshots;
  snapshots.reserve(states.size());
  for (const v1::State& state : states) {
    snapshots.push_back(state.snapshot());
  }
  return snapshots;
}

class StatesTest : public ServiceTest {
 protected:
  // The states of all environments of `pool`.
  std::vector<v1::State> Saved(const std::string& pool) {
    absl::StatusOr<std::vector<v1::State>> states = client_->SaveStates(pool);
    EXPECT_THAT(states, IsOk());
    return states.ok() ? *std::move(states) : std::vector<v1::State>();
  }
};

class EveryGameStatesTest : public StatesTest, public testing::WithParamInterface<std::string> {};

TEST_P(EveryGameStatesTest, RestoredStatesOnAnotherServerContinueAsTheOriginals) {
  v1::PoolSpec spec = MazeSpec(kSavedCount);
  *spec.mutable_games(0) = GetParam();
  v1::PoolSpec other_spec = spec;
  other_spec.set_env_count(kOtherCount);
  other_spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_HARD);
  other_spec.mutable_options()->set_use_monochrome_assets(true);
  const auto other_server = StartServer(/*worker_count=*/1);
  const auto other_client = procgen_client::Client::Connect(other_server->address());
  ASSERT_THAT(other_client, IsOk());
  const std::string other_name = (*other_client)->CreatePool(other_spec)->name();
  const auto other = (*other_client)->Attach(other_name);
  ASSERT_THAT(other, IsOk());
  const std::string name = CreatePool(spec);
  const auto stream = client_->Attach(name);
  ASSERT_THAT(stream, IsOk());

  for (const int steps_between : {0, 23, 61}) {
    Played(stream->get(), steps_between, kSavedCount, steps_between);
    Played(other->get(), 6, kOtherCount, 7);
    std::vector<v1::State> states = Saved(name);
    ASSERT_THAT(states, SizeIs(kSavedCount));
    std::swap(states.front(), states.back());
    ASSERT_THAT((*other_client)->RestoreStates(other_name, states), IsOk());

    const auto continued = Played(stream->get(), 9, kSavedCount, kStepsAfter);
    EXPECT_EQ(Played(other->get(), 9, kSavedCount, kStepsAfter), continued);
  }
}

std::vector<std::string> AllGames() {
  std::vector<std::string> games;
  for (const GameSpec& spec : GameCatalog()) {
    games.emplace_back(spec.name);
  }
  return games;
}

INSTANTIATE_TEST_SUITE_P(Games, EveryGameStatesTest, testing::ValuesIn(AllGames()),
                         [](const auto& info) { return info.param; });

TEST_F(StatesTest, EpisodesEndDuringTheComparison) {
  const auto stream = CreateAndAttach(MazeSpec(kSavedCount));
  size_t ended = 0;
  for (const BatchCopy& batch : Played(stream.get(), 9, kSavedCount, kStepsAfter)) {
    ended += batch.fingerprints.size();
  }
  EXPECT_GT(ended, 0U);
}

TEST_F(StatesTest, SavingChangesNothingAndReturnsTheSequenceNumber) {
  const std::string name = CreatePool(MazeSpec(3));
  const auto stream = client_->Attach(name);
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*stream)->Step({7, 7, 7}, &batch), IsOk());
  ASSERT_THAT((*stream)->Observe(&batch), IsOk());
  const BatchCopy before(batch);
  v1::SaveStatesRequest request;
  request.set_pool(name);
  request.add_environments(2);
  request.add_environments(0);
  v1::SaveStatesResponse response;
  grpc::ClientContext context;
  ASSERT_TRUE(v1::StateService::NewStub(channel_)->SaveStates(&context, request, &response).ok());
  EXPECT_EQ(response.sequence_number(), 2);
  EXPECT_EQ(response.next_page_token(), "");
  ASSERT_EQ(response.states_size(), 2);
  EXPECT_EQ(response.states(0).environment(), 2);
  EXPECT_EQ(response.states(1).environment(), 0);
  ASSERT_THAT((*stream)->Observe(&batch), IsOk());
  EXPECT_EQ(batch.sequence_number(), 3);
  EXPECT_EQ(BatchCopy(batch), before);
}

TEST_F(StatesTest, CloneWithinAPoolExchangesStates) {
  const std::string name = CreatePool(MazeSpec(4));
  const std::vector<std::string> before = SnapshotsOf(Saved(name));
  ASSERT_THAT(client_->CloneStates(name, {Pair(0, 1), Pair(1, 0), Pair(0, 3)}), IsOk());
  EXPECT_THAT(SnapshotsOf(Saved(name)), ElementsAre(before[1], before[0], before[2], before[0]));
}

TEST_F(StatesTest, CloneFromAnotherPoolMayRepeatSources) {
  const std::string source = CreatePool(MazeSpec(4));
  v1::PoolSpec spec = MazeSpec(3);
  spec.mutable_options()->set_rand_seed(99);
  const std::string target = CreatePool(spec);
  const std::vector<std::string> read = SnapshotsOf(Saved(source));
  const std::vector<std::string> before = SnapshotsOf(Saved(target));
  ASSERT_THAT(client_->CloneStates(target, {Pair(3, 0), Pair(3, 2)}, {source, ""}), IsOk());
  EXPECT_THAT(SnapshotsOf(Saved(target)), ElementsAre(read[3], before[1], read[3]));
  EXPECT_EQ(SnapshotsOf(Saved(source)), read);
}

TEST_F(StatesTest, NextLevelAfterARestoredEpisodeFollowsThePool) {
  v1::PoolSpec spec = MazeSpec(2);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_NEXT_STEP);
  const std::string ended = CreatePool(spec);
  const auto ending = client_->Attach(ended);
  ASSERT_THAT(ending, IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*ending)->Step({-1, 4}, &batch), IsOk());
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const std::string name = CreatePool(spec);
  const auto stream = client_->Attach(name);
  ASSERT_THAT(stream, IsOk());

  ASSERT_THAT(client_->CloneStates(name, {Pair(0, 1)}, {ended, ""}), IsOk());
  EXPECT_THAT((*stream)->Step({4, 4}, &batch),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("the episode of environment 1 of pool " + name + " has ended")));
}

TEST_F(StatesTest, AutoresetEpisodeNeedsNoReset) {
  const std::string name = CreatePool(MazeSpec(1));
  const auto stream = client_->Attach(name);
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*stream)->Step({-1}, &batch), IsOk());
  v1::PoolSpec spec = MazeSpec(1);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const std::string disabled = CreatePool(spec);
  const auto target = client_->Attach(disabled);
  ASSERT_THAT(target, IsOk());
  ASSERT_THAT(client_->CloneStates(disabled, {Pair(0, 0)}, {name, ""}), IsOk());
  ASSERT_THAT((*target)->Observe(&batch), IsOk());
  EXPECT_THAT(batch.terminated(), ElementsAre(true));
  EXPECT_THAT((*target)->Step({4}, &batch), IsOk());
}

TEST_F(StatesTest, RestoredEndedEnvironmentCanBeStepped) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  const std::string name = CreatePool(spec);
  const auto stream = client_->Attach(name);
  ASSERT_THAT(stream, IsOk());
  const std::vector<v1::State> running = Saved(name);
  procgen_client::Batch batch;
  ASSERT_THAT((*stream)->Step({-1}, &batch), IsOk());
  ASSERT_THAT(client_->RestoreStates(name, running), IsOk());
  EXPECT_THAT((*stream)->Step({4}, &batch), IsOk());
}

TEST_F(StatesTest, DrainingServerStillSavesStates) {
  const std::string name = CreatePool(MazeSpec(2));
  server_is_alive_ = false;
  server_->BeginDrain();
  const std::vector<v1::State> states = Saved(name);
  EXPECT_THAT(states, SizeIs(2));
  EXPECT_THAT(client_->RestoreStates(name, states), IsOk());
  EXPECT_THAT(client_->CloneStates(name, {Pair(0, 1)}), IsOk());
}

// Requests of all environments' states, in pages of the smallest response size.
class StatesPagesTest : public StatesTest {
 protected:
  void SetUp() override {
    StatesTest::SetUp();
    name_ = CreatePool(MazeSpec(kEnvCount));
    request_.set_pool(name_);
    request_.set_response_bytes_max(65536);
  }

  absl::Status NextPage() {
    grpc::ClientContext context;
    const grpc::Status status =
        v1::StateService::NewStub(channel_)->SaveStates(&context, request_, &page_);
    request_.set_page_token(page_.next_page_token());
    return {static_cast<absl::StatusCode>(status.error_code()), status.error_message()};
  }

  static constexpr int32_t kEnvCount = 300;
  std::string name_;
  v1::SaveStatesRequest request_;
  v1::SaveStatesResponse page_;
};

TEST_F(StatesPagesTest, PagesFitAndContainEachStateOnce) {
  int32_t next = 0;
  int pages = 0;
  do {
    ASSERT_THAT(NextPage(), IsOk());
    EXPECT_LE(page_.ByteSizeLong(), 65536U);
    for (const v1::State& state : page_.states()) {
      EXPECT_EQ(state.environment(), next++);
    }
    ++pages;
  } while (!page_.next_page_token().empty());
  EXPECT_EQ(next, kEnvCount);
  EXPECT_GT(pages, 2);
}

TEST_F(StatesPagesTest, ObservingBetweenPagesIsAllowed) {
  const auto stream = client_->Attach(name_);
  ASSERT_THAT(stream, IsOk());
  ASSERT_THAT(NextPage(), IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*stream)->Observe(&batch), IsOk());
  EXPECT_THAT(NextPage(), IsOk());
}

TEST_F(StatesPagesTest, StepOrRestoreBetweenPagesIsAborted) {
  const auto stream = client_->Attach(name_);
  ASSERT_THAT(stream, IsOk());
  const auto aborted =
      StatusIs(absl::StatusCode::kAborted,
               "environments of pool " + name_ +
                   " were stepped, reset or restored since the previous page; start "
                   "again without page_token");
  ASSERT_THAT(NextPage(), IsOk());
  EXPECT_THAT(CallStatus(stream->get(), SliceStepRequest(299, 1, 4)), IsOk());
  EXPECT_THAT(NextPage(), aborted);
  request_.clear_page_token();
  ASSERT_THAT(NextPage(), IsOk());
  ASSERT_THAT(client_->CloneStates(name_, {Pair(0, 299)}), IsOk());
  EXPECT_THAT(NextPage(), aborted);
}

TEST_F(StatesPagesTest, PageTokensOfOtherRequestsAreRejected) {
  ASSERT_THAT(NextPage(), IsOk());
  const std::string token = request_.page_token();
  const auto rejected = StatusIs(
      absl::StatusCode::kInvalidArgument,
      HasSubstr("allowed: the next_page_token of the previous response, with the same pool and "
                "environments"));
  for (const std::string& wrong :
       {std::string("nonsense"), "9999" + token, token + "0", std::string("-1-0-0"),
        std::string("1-0-0"), std::string(60000, '9')}) {
    request_.set_page_token(wrong);
    EXPECT_THAT(NextPage(), rejected) << wrong;
  }
  request_.set_page_token(token);
  request_.add_environments(0);
  EXPECT_THAT(NextPage(), rejected);
}

}  // namespace
}  // namespace procgen
