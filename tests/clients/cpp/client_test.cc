#include "procgen_client/client.h"

#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::SizeIs;

class ClientTest : public ServiceTest {};

TEST_F(ClientTest, ConnectWithoutListenerFailsSoonAndSaysSo) {
  const absl::Time begin = absl::Now();
  EXPECT_THAT(procgen_client::Client::Connect("127.0.0.1:1"),
              StatusIs(absl::StatusCode::kUnavailable,
                       "no server listens at 127.0.0.1:1: Connection refused"));
  EXPECT_THAT(procgen_client::Client::Connect("unix:/no/such/socket"),
              StatusIs(absl::StatusCode::kUnavailable,
                       "no server listens at unix:/no/such/socket: No such file or directory"));
  EXPECT_LT(absl::Now() - begin, absl::Seconds(8)) << "of 2 x 10 s that a silent server has";
}

TEST_F(ClientTest, GivenTimeoutAlsoHoldsWhileNothingListens) {
  procgen_client::ConnectOptions options;
  options.timeout = absl::Milliseconds(2200);
  const absl::Time begin = absl::Now();
  EXPECT_THAT(procgen_client::Client::Connect("127.0.0.1:1", options),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("Connection refused")));
  EXPECT_GE(absl::Now() - begin, *options.timeout) << "the server may still be starting";
}

TEST_F(ClientTest, AddressWithoutPortIsRejectedAtOnce) {
  for (const char* address : {"localhost", "", "http://localhost:50051", "::1:50051",
                              "localhost:", "localhost:0", "localhost:65536", "localhost:http"}) {
    EXPECT_THAT(procgen_client::Client::Connect(address),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         HasSubstr("it is host:port (localhost:50051, [::1]:50051)")))
        << address;
  }
}

TEST_F(ClientTest, StreamErrorIsSticky) {
  const auto stream = CreateAndAttach(MazeSpec(1));
  procgen_client::Batch batch;
  const absl::Status error = stream->Step({99}, &batch);
  EXPECT_THAT(error, StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("99")));
  EXPECT_EQ(stream->Send(StepRequest({4})).status(), error);
  EXPECT_EQ(stream->Receive(&batch), error);
  EXPECT_EQ(stream->Close(), error);
}

TEST_F(ClientTest, ClosedStreamRejectsStepsAndFreesItsPool) {
  const std::string name = CreatePool(MazeSpec(1));
  auto stream = client_->Attach(name);
  ASSERT_THAT(stream, IsOk());
  EXPECT_THAT((*stream)->Close(), IsOk());
  procgen_client::Batch batch;
  EXPECT_THAT((*stream)->Step({4}, &batch),
              StatusIs(absl::StatusCode::kFailedPrecondition, "the stream is closed"));
  EXPECT_THAT(client_->Attach(name), IsOk());
}

TEST_F(ClientTest, StepNeedsAllResponsesReceived) {
  const auto stream = CreateAndAttach(MazeSpec(1));
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Send(StepRequest({4})), IsOk());
  EXPECT_THAT(stream->Step({4}, &batch),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("unanswered")));
  EXPECT_THAT(stream->Receive(&batch), IsOk());
  EXPECT_THAT(stream->Step({4}, &batch), IsOk());
}

TEST_F(ClientTest, ReceiveWithoutRequestIsAnError) {
  const auto stream = CreateAndAttach(MazeSpec(1));
  procgen_client::Batch batch;
  EXPECT_THAT(stream->Receive(&batch),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("no request")));
}

TEST_F(ClientTest, ChunkedResponsesAreJoined) {
  const auto stream = CreateAndAttach(MazeSpec(400));
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Step(std::vector<int32_t>(400, 4), &batch), IsOk());
  EXPECT_EQ(batch.first_env(), 0);
  EXPECT_EQ(batch.env_count(), 400);
  EXPECT_THAT(batch.episode_lengths(), SizeIs(400));
  EXPECT_THAT(batch.episode_lengths(), Each(1));
  EXPECT_THAT(batch.observations(), SizeIs(400UL * 64 * 64 * 3));
}

TEST_F(ClientTest, FingerprintsAreThoseOfTheRowsThatEnded) {
  const auto stream = CreateAndAttach(MazeSpec(400));
  std::vector<int32_t> actions(400, 4);
  actions[3] = -1;
  actions[399] = -1;  // in the second response
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Step(actions, &batch), IsOk());
  EXPECT_THAT(batch.fingerprints(), SizeIs(2));
  const std::vector<uint64_t> both(batch.fingerprints().begin(), batch.fingerprints().end());
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  EXPECT_THAT(batch.fingerprints(), testing::ElementsAreArray(both));
  ASSERT_THAT(stream->Step(std::vector<int32_t>(400, 4), &batch), IsOk());
  EXPECT_THAT(batch.fingerprints(), SizeIs(0));
}

TEST_F(ClientTest, LargeRestoreIsSplitIntoRequests) {
  const std::string name = CreatePool(MazeSpec(300));
  const auto states = client_->SaveStates(name);
  ASSERT_THAT(states, IsOk());
  ASSERT_THAT(*states, SizeIs(300));
  size_t bytes = 0;
  for (const v1::State& state : *states) {
    bytes += state.snapshot().size();
  }
  ASSERT_GT(bytes, static_cast<size_t>(2 * TestLimits().request_bytes_max));
  {
    const auto stream = client_->Attach(name);
    ASSERT_THAT(stream, IsOk());
    procgen_client::Batch batch;
    ASSERT_THAT((*stream)->Step(std::vector<int32_t>(300, -1), &batch), IsOk());
  }
  ASSERT_THAT(client_->RestoreStates(name, *states), IsOk());
  const auto again = client_->SaveStates(name);
  ASSERT_THAT(again, IsOk());
  for (size_t i = 0; i < states->size(); ++i) {
    EXPECT_EQ((*again)[i].snapshot(), (*states)[i].snapshot());
  }
}

TEST_F(ClientTest, StatesComeInRequestOrder) {
  const std::string name = CreatePool(MazeSpec(4));
  const auto states = client_->SaveStates(name, {2, 0});
  ASSERT_THAT(states, IsOk());
  ASSERT_THAT(*states, SizeIs(2));
  EXPECT_EQ(states->front().environment(), 2);
  EXPECT_EQ(states->back().environment(), 0);
}

TEST_F(ClientTest, ClonesReadFromTheGivenSource) {
  const std::string source = CreatePool(MazeSpec(2));
  v1::PoolSpec spec = MazeSpec(2);
  spec.mutable_options()->set_rand_seed(99);
  const std::string target = CreatePool(spec);
  const std::string read = client_->SaveStates(source, {1})->front().snapshot();
  ASSERT_THAT(client_->CloneStates(target, {Pair(1, 0)}, {source, server_->address()}), IsOk());
  EXPECT_EQ(client_->SaveStates(target, {0})->front().snapshot(), read);
  ASSERT_THAT(client_->CloneStates(target, {Pair(0, 1)}), IsOk());
  EXPECT_EQ(client_->SaveStates(target, {1})->front().snapshot(), read);
}

TEST_F(ClientTest, DroppedStreamWithUnreadResponsesFreesItsPool) {
  const std::string name = CreatePool(MazeSpec(16));
  {
    const auto stream = client_->Attach(name);
    ASSERT_THAT(stream, IsOk());
    ASSERT_THAT((*stream)->Send(StepRequest(std::vector<int32_t>(16, 4))), IsOk());
  }
  const auto again = client_->Attach(name);
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ((*again)->pool().next_sequence_number(), 2);
}

}  // namespace
}  // namespace procgen
