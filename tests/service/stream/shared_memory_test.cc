// Pools whose batches are in shared memory.

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "server/rpc/server.h"
#include "tests/service/robustness/broken_connection.h"
#include "tests/service/service_fixture.h"
#include "tests/service/stream/batch_copy.h"
#include "tests/service/stream/shared_memory_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct Case {
  std::string name;
  std::vector<std::string> games;
  v1::AutoresetMode autoreset_mode = v1::AUTORESET_MODE_SAME_STEP;
  bool small_stacks = false;
};

class SharedBatchesTest : public SharedMemoryTest, public testing::WithParamInterface<Case> {
 protected:
  static constexpr int32_t kEnvCount = 6;

  static v1::PoolSpec Spec() {
    v1::PoolSpec spec;
    spec.mutable_games()->Assign(GetParam().games.begin(), GetParam().games.end());
    spec.set_env_count(kEnvCount);
    spec.set_autoreset_mode(GetParam().autoreset_mode);
    spec.mutable_options()->set_rand_seed(3);
    if (GetParam().small_stacks) {
      spec.mutable_observation_format()->set_size_px(20);
      spec.mutable_observation_format()->set_color(v1::COLOR_GRAYSCALE);
      spec.mutable_observation_format()->set_layout(v1::LAYOUT_CHW);
      spec.mutable_observation_format()->set_frame_stack(3);
    }
    return spec;
  }

  // Request `number`: slices, repeats, ends, resets and steps without observations in turn.
  // `awaiting`: environments that must be reset.
  static v1::StepPoolRequest RequestAt(int number, const std::vector<bool>& awaiting) {
    const bool is_part = number % 3 == 1;
    v1::StepPoolRequest request =
        is_part ? SliceStepRequest(2, 3, 4) : SliceStepRequest(0, kEnvCount, 4);
    v1::Step* step = request.mutable_step();
    const int32_t first = step->slice().first_env();
    for (int row = 0; row < step->actions_size(); ++row) {
      step->set_actions(row, (number / 4 * 7 + (first + row) * 5) % 16 - 1);
      if (number % 10 == 9) {
        step->set_actions(row, -1);
      }
    }
    step->set_repeat_count(number % 7 == 3 ? 3 : 1);
    step->set_with_final_observations(number % 2 == 0);
    step->set_observation(number % 5 == 4 ? v1::OBSERVATION_NONE : v1::OBSERVATION_FRAME);
    for (int row = 0; row < step->actions_size(); ++row) {
      const int32_t environment = first + row;
      if (number % 10 == 0 || awaiting[static_cast<size_t>(environment)]) {
        step->add_resets()->set_environment(environment);
      }
    }
    return request;
  }
};

TEST_P(SharedBatchesTest, BatchesEqualThoseOfTheGrpcStream) {
  const auto stream = Attach(CreatePool(Spec()));
  const auto shared = Attach(CreatePool(SharedSpec(Spec())));
  ASSERT_NE(stream, nullptr);
  ASSERT_NE(shared, nullptr);
  EXPECT_EQ(shared->pool().spec().transport(), v1::TRANSPORT_SHARED_MEMORY);
  procgen_client::Batch expected;
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Observe(&expected), IsOk());
  ASSERT_THAT(shared->Observe(&batch), IsOk());
  ASSERT_EQ(BatchCopy(batch), BatchCopy(expected));
  std::vector<bool> awaiting(kEnvCount, false);
  for (int number = 0; number < 200; ++number) {
    const v1::StepPoolRequest request = RequestAt(number, awaiting);
    ASSERT_THAT(stream->Call(request, &expected), IsOk());
    ASSERT_THAT(shared->Call(request, &batch), IsOk());
    ASSERT_EQ(batch.first_env(), expected.first_env());
    ASSERT_EQ(batch.env_count(), expected.env_count());
    ASSERT_EQ(batch.sequence_number(), expected.sequence_number());
    ASSERT_EQ(BatchCopy(batch), BatchCopy(expected)) << "in request " << number;
    for (int32_t row = 0; row < batch.env_count(); ++row) {
      const auto place = static_cast<size_t>(row);
      const int32_t environment = batch.first_env() + row;
      awaiting[static_cast<size_t>(environment)] =
          GetParam().autoreset_mode == v1::AUTORESET_MODE_DISABLED &&
          (batch.terminated()[place] || batch.truncated()[place]);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Cases, SharedBatchesTest,
    testing::Values(
        Case{.name = "Bigfish", .games = {"bigfish"}},
        Case{.name = "NextStep", .games = {"maze"}, .autoreset_mode = v1::AUTORESET_MODE_NEXT_STEP},
        Case{.name = "Disabled",
             .games = {"coinrun"},
             .autoreset_mode = v1::AUTORESET_MODE_DISABLED},
        Case{.name = "Stacks", .games = {"starpilot", "maze", "coinrun"}, .small_stacks = true}),
    [](const testing::TestParamInfo<Case>& info) { return info.param.name; });

TEST_F(SharedMemoryTest, HeldBatchesAreNotOverwrittenAndExcessIsRejectedLocally) {
  const auto stream = Attach(CreatePool(SharedSpec(MazeSpec(2))), {.held_batches_max = 3});
  ASSERT_NE(stream, nullptr);
  std::vector<procgen_client::Batch> held(5);  // 2 in flight and 3
  std::vector<BatchCopy> copies;
  for (procgen_client::Batch& batch : held) {
    ASSERT_THAT(stream->Step({7, 1}, &batch), IsOk());
    copies.emplace_back(batch);
  }
  procgen_client::Batch another;
  EXPECT_THAT(stream->Step({7, 1}, &another),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("5 Batches are held"), HasSubstr("has 5"))));
  for (size_t i = 0; i < held.size(); ++i) {
    EXPECT_EQ(BatchCopy(held[i]), copies[i]);
  }
  held[2] = procgen_client::Batch();
  for (int step = 0; step < 50; ++step) {
    ASSERT_THAT(stream->Step({7, 1}, &another), IsOk());
  }
  for (const size_t i : {0, 1, 3, 4}) {
    EXPECT_EQ(BatchCopy(held[i]), copies[i]);
  }
}

TEST_F(SharedMemoryTest, ReleasedBatchesAreReused) {
  const auto stream = Attach(CreatePool(SharedSpec(MazeSpec(2))));
  ASSERT_NE(stream, nullptr);
  ASSERT_THAT(stream->SendStep({7, 1}), IsOk());
  procgen_client::Batch batch;
  std::set<const uint8_t*> places;
  for (int step = 0; step < 20; ++step) {
    batch.Release();
    EXPECT_TRUE(batch.observations().empty());
    ASSERT_THAT(stream->SendStep({7, 1}), IsOk());
    ASSERT_THAT(stream->Receive(&batch), IsOk());
    places.insert(batch.observations().data());
  }
  EXPECT_EQ(places.size(), 2) << "one is read while the other is written";
}

TEST_F(SharedMemoryTest, BatchesOutliveTheirStreamAndTheirServer) {
  procgen_client::Batch batch;
  {
    const auto stream = Attach(CreatePool(SharedSpec(MazeSpec(2))));
    ASSERT_THAT(stream->Observe(&batch), IsOk());
  }
  const BatchCopy copy(batch);
  client_ = nullptr;
  server_ = nullptr;
  EXPECT_EQ(BatchCopy(batch), copy);
}

TEST_F(SharedMemoryTest, LargeBatchesAreOneResponse) {
  v1::PoolSpec spec = MazeSpec(4);
  spec.mutable_observation_format()->set_size_px(512);
  spec.mutable_observation_format()->set_frame_stack(8);
  const auto stream = Attach(CreatePool(SharedSpec(spec)), {.response_bytes_max = 65536});
  ASSERT_NE(stream, nullptr);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  EXPECT_EQ(batch.observations().size(), size_t{4} * 8 * 512 * 512 * 3);
}

TEST_F(SharedMemoryTest, HostileBatchNumbersAreRejected) {
  const std::string pool = CreatePool(SharedSpec(MazeSpec(1)));
  const std::string stream_pool = CreatePool(MazeSpec(1));
  for (const std::vector<int32_t>& released :
       {std::vector<int32_t>{0}, {-1}, {4}, {INT32_MAX}, {INT32_MIN}, {1, 1}}) {
    v1::StepPoolRequest request = StepRequest({4});
    request.mutable_released_batches()->Assign(released.begin(), released.end());
    EXPECT_THAT(StatusOfRaw(pool, {}, request),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("released_batches[0] is ")));
    EXPECT_THAT(StatusOfRaw(stream_pool, {}, request),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("shares no memory")));
  }
  for (const std::vector<int32_t>& held :
       {std::vector<int32_t>{4}, {-1}, {0, 0}, {INT32_MAX}, {INT32_MIN}}) {
    EXPECT_THAT(StatusOfRaw(pool, held, StepRequest({4})),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("attach.held_batches")));
    EXPECT_THAT(StatusOfRaw(stream_pool, held, StepRequest({4})),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("shares no memory")));
  }
  EXPECT_THAT(StatusOfRaw(pool, {0, 1, 2}, StepRequest({4})), IsOk());
  EXPECT_THAT(StatusOfRaw(pool, {0, 1, 2, 3}, StepRequest({4})),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("holds 4 of the 4")));
  EXPECT_EQ(client_->GetPool(pool)->next_sequence_number(), 2) << "rejected requests take none";
  EXPECT_THAT(StatusOfRaw(pool, {}, StepRequest({4})), IsOk()) << "attach released all batches";
}

TEST_F(SharedMemoryTest, NothingIsLostOnABadNetwork) {
  ExpectNothingIsLost(server_->address(), 5, 30, {.transport = v1::TRANSPORT_SHARED_MEMORY});
  ExpectNothingIsLost(server_->address(), 6, 30,
                      {.transport = v1::TRANSPORT_SHARED_MEMORY, .pipe_transport = false});
}

TEST_F(SharedMemoryTest, AttachBeyondTheLimitIsRejected) {
  Limits limits;
  limits.shared_memory_bytes_max = 1 << 20;
  Use(StartServer(limits));
  EXPECT_EQ(client_->GetCatalog()->limits().shared_memory_bytes_max(), 1 << 20);
  const std::string pool = CreatePool(SharedSpec(MazeSpec(10)));
  const auto stream = Attach(pool);
  EXPECT_NE(stream, nullptr);
  EXPECT_THAT(client_->Attach(CreatePool(SharedSpec(MazeSpec(2)))),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("limit shared_memory_bytes_max is 1048576")));
  EXPECT_THAT(stream->Close(), IsOk());
  EXPECT_THAT(client_->Attach(pool, {.held_batches_max = 20}),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("22 batches")));
  EXPECT_FALSE(client_->GetPool(pool)->attached());
  EXPECT_NE(Attach(pool), nullptr);
  EXPECT_THAT(client_->DeletePool(pool), IsOk());
}

TEST_F(SharedMemoryTest, SlotsGrowAndMappingsStayValid) {
  const std::string pool = CreatePool(SharedSpec(MazeSpec(1)));
  procgen_client::Batch batch;
  std::unique_ptr<procgen_client::StepStream> first = Attach(pool);
  ASSERT_THAT(first->Observe(&batch), IsOk());
  const BatchCopy copy(batch);
  ASSERT_THAT(first->Close(), IsOk());
  const auto second = Attach(pool, {.held_batches_max = 9});
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(BatchCopy(batch), copy);
  std::vector<procgen_client::Batch> held(11);
  for (procgen_client::Batch& each : held) {
    ASSERT_THAT(second->Observe(&each), IsOk());
    EXPECT_EQ(BatchCopy(each), copy);
  }
}

TEST_F(SharedMemoryTest, ServerWithoutSharedMemoryDirDoesNotOfferIt) {
  ServerOptions options;
  options.address = "127.0.0.1:0";
  const auto server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  const auto client = procgen_client::Client::Connect((*server)->address());
  EXPECT_THAT(client_->GetCatalog()->transports(),
              testing::ElementsAre(v1::TRANSPORT_STREAM, v1::TRANSPORT_SHARED_MEMORY));
  EXPECT_THAT((*client)->GetCatalog()->transports(), testing::ElementsAre(v1::TRANSPORT_STREAM));
  EXPECT_THAT((*client)->CreatePool(SharedSpec(MazeSpec(1))),
              StatusIs(absl::StatusCode::kUnimplemented, HasSubstr("offered: TRANSPORT_STREAM")));
}

TEST_F(SharedMemoryTest, UnixSocketsCountAsLocal) {
  Use(StartServer({}, absl::StrCat("unix:", folder_.path(), ".socket")));
  procgen_client::Batch batch;
  const auto stream = Attach(CreatePool(SharedSpec(MazeSpec(1))));
  ASSERT_NE(stream, nullptr);
  EXPECT_THAT(stream->Observe(&batch), IsOk());
}

// A non-loopback IPv4 address of this machine; empty if it has none.
std::string OtherAddress() {
  ifaddrs* all = nullptr;
  std::string found;
  if (getifaddrs(&all) != 0) {
    return found;
  }
  for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
    if (each->ifa_addr != nullptr && each->ifa_addr->sa_family == AF_INET &&
        (each->ifa_flags & IFF_LOOPBACK) == 0) {
      char text[INET_ADDRSTRLEN] = {};
      const auto* address = reinterpret_cast<const sockaddr_in*>(each->ifa_addr);
      found = inet_ntop(AF_INET, &address->sin_addr, text, sizeof(text));
    }
  }
  freeifaddrs(all);
  return found;
}

TEST_F(SharedMemoryTest, RemoteLearnersAreRejected) {
  const std::string other = OtherAddress();
  if (other.empty()) {
    GTEST_SKIP() << "this machine has no address but loopback";
  }
  Use(StartServer({}, absl::StrCat(other, ":0")));
  const std::string pool = CreatePool(SharedSpec(MazeSpec(1)));
  EXPECT_THAT(client_->Attach(pool),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr(other), HasSubstr("TRANSPORT_STREAM"))));
}

TEST_F(SharedMemoryTest, UnmappableFilesAreNamed) {
  const std::string pool = CreatePool(SharedSpec(MazeSpec(1)));
  ASSERT_NE(Attach(pool), nullptr);
  // As if the client saw a different folder at that path.
  const std::filesystem::directory_entry file =
      *std::filesystem::directory_iterator(folder_.path());
  const std::string name = file.path().filename();
  std::filesystem::rename(file.path(), folder_.path() + ".away");
  EXPECT_THAT(client_->Attach(pool),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr(name), HasSubstr("TRANSPORT_STREAM"))));
  std::ofstream(file.path()) << "short";
  EXPECT_THAT(client_->Attach(pool, {.take_over = true}),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr(name), HasSubstr("shorter"))));
  std::filesystem::remove(folder_.path() + ".away");
}

}  // namespace
}  // namespace procgen
