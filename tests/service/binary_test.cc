// procgen-server as a program: flags, startup and shutdown.

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/envcore/pool/painted_art.h"
#include "tests/service/server_process.h"
#include "tests/service/service_fixture.h"
#include "tests/service/stream/batch_copy.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class SignalTest : public testing::TestWithParam<int> {};

// Steps until the server reports that it drains.
void StepUntilItDrains(procgen_client::StepStream* stream) {
  procgen_client::Batch batch;
  absl::Status status;
  while (status.ok()) {
    status = stream->Step({4, 4, 4, 4}, &batch);
  }
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
}

TEST_P(SignalTest, DrainsAndExitsWithZero) {
  ServerProcess process({"--address=127.0.0.1:0", "--workers=2", "--drain_timeout=1h"});
  const std::string address = process.Address();
  ASSERT_NE(address, "");
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  const auto pool = (*client)->CreatePool(MazeSpec(4));
  ASSERT_THAT(pool, IsOk());
  const auto stream = (*client)->Attach(pool->name());
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*stream)->Step({4, 4, 4, 4}, &batch), IsOk());
  process.Signal(GetParam());
  StepUntilItDrains(stream->get());
  EXPECT_THAT((*client)->DeletePool(pool->name()), IsOk());
  EXPECT_EQ(process.Wait(), 0);
  EXPECT_THAT(process.rest(), HasSubstr("event=draining"));
  EXPECT_THAT(process.rest(), HasSubstr("event=stopped"));
}

INSTANTIATE_TEST_SUITE_P(Signals, SignalTest, testing::Values(SIGTERM, SIGINT));

TEST(DrainingTest, LearnerContinuesOnAnotherServer) {
  ServerProcess leaving({"--address=127.0.0.1:0", "--drain_timeout=1h"});
  ServerProcess staying({"--address=127.0.0.1:0"});
  const auto before = procgen_client::Client::Connect(leaving.Address());
  const auto after = procgen_client::Client::Connect(staying.Address());
  ASSERT_THAT(before, IsOk());
  ASSERT_THAT(after, IsOk());
  const auto left = (*before)->CreatePool(MazeSpec(4));
  const auto continued = (*after)->CreatePool(MazeSpec(4));
  const auto expected = (*after)->CreatePool(MazeSpec(4));
  const auto left_stream = (*before)->Attach(left->name());
  ASSERT_THAT(left_stream, IsOk());
  leaving.Signal(SIGTERM);
  StepUntilItDrains(left_stream->get());
  const int64_t next = (*before)->GetPool(left->name())->next_sequence_number();
  const auto states = (*before)->SaveStates(left->name());
  ASSERT_THAT(states, IsOk());
  ASSERT_THAT((*before)->DeletePool(left->name()), IsOk());
  EXPECT_EQ(leaving.Wait(), 0);

  ASSERT_THAT((*after)->RestoreStates(continued->name(), *states), IsOk());
  const auto stream = (*after)->Attach(continued->name());
  const auto expected_stream = (*after)->Attach(expected->name());
  procgen_client::Batch batch;
  procgen_client::Batch expected_batch;
  for (int64_t number = 1; number < next; ++number) {
    ASSERT_THAT((*expected_stream)->Step({4, 4, 4, 4}, &expected_batch), IsOk());
  }
  for (const int32_t action : {7, 1, -1, 7}) {
    const std::vector<int32_t> actions(4, action);
    ASSERT_THAT((*stream)->Step(actions, &batch), IsOk());
    ASSERT_THAT((*expected_stream)->Step(actions, &expected_batch), IsOk());
    EXPECT_THAT(batch.rewards(), testing::ElementsAreArray(expected_batch.rewards()));
    EXPECT_THAT(batch.fingerprints(), testing::ElementsAreArray(expected_batch.fingerprints()));
    EXPECT_THAT(batch.observations() == expected_batch.observations(), testing::IsTrue());
  }
}

TEST(DrainingTest, DrainWaitsForAttachedPoolsUntilTheTimeout) {
  ServerProcess process({"--address=127.0.0.1:0", "--drain_timeout=1s"});
  const auto client = procgen_client::Client::Connect(process.Address());
  ASSERT_THAT(client, IsOk());
  const auto stream = (*client)->Attach((*client)->CreatePool(MazeSpec(4))->name());
  ASSERT_THAT(stream, IsOk());
  const absl::Time begin = absl::Now();
  process.Signal(SIGTERM);
  StepUntilItDrains(stream->get());
  EXPECT_EQ(process.Wait(), 0);
  EXPECT_GE(absl::Now() - begin, absl::Seconds(1));
}

TEST(DrainingTest, IdlePoolsAndConnectionsDoNotDelayDrain) {
  ServerProcess process({"--address=127.0.0.1:0", "--drain_timeout=1h"});
  const auto client = procgen_client::Client::Connect(process.Address());
  ASSERT_THAT(client, IsOk());
  ASSERT_THAT((*client)->CreatePool(MazeSpec(4)), IsOk());
  process.Signal(SIGTERM);
  EXPECT_EQ(process.Wait(), 0);
}

// The first observation of a maze on the server at `address`. Expects that its catalog reports
// `art`.
std::string FirstPictureOf(const std::string& address, const std::string& art) {
  const auto client = procgen_client::Client::Connect(address);
  EXPECT_THAT(client, IsOk());
  const auto catalog = (*client)->GetCatalog();
  EXPECT_THAT(catalog, IsOk());
  EXPECT_EQ(catalog->art(), art);
  const auto pool = (*client)->CreatePool(MazeSpec(1));
  EXPECT_THAT(pool, IsOk());
  const auto stream = (*client)->Attach(pool->name());
  EXPECT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  EXPECT_THAT((*stream)->Observe(&batch), IsOk());
  return {batch.observations().begin(), batch.observations().end()};
}

TEST(BinaryTest, HelpListsTheFlags) {
  ServerProcess process({"--help"});
  EXPECT_EQ(process.Wait(), 0);
  for (const char* flag :
       {"--address", "--workers", "--pool_count_max", "--request_bytes_max",
        "--requests_in_flight_max", "--drain_timeout", "--art_dir", "--log_level",
        "--tls_certificate", "--tokens", "--allow_insecure", "--clone_source_allowlist",
        "--owner_pool_count_max", "--resume_buffer_bytes_max", "--lease_duration_max",
        "--keepalive_time", "--keepalive_timeout", "--metrics_address", "--web_address"}) {
    EXPECT_THAT(process.rest(), HasSubstr(flag));
  }
}

TEST(BinaryTest, InvalidFlagsAreReported) {
  ServerProcess process({"--workers=-3"});
  EXPECT_EQ(process.Wait(), 2);
  EXPECT_THAT(process.rest(), HasSubstr("--workers is -3, allowed: 1 to 1024"));
}

TEST(BinaryTest, FlagsThatCannotBeParsedExitWithTwo) {
  const TemporaryFolder temporary;
  const std::string flag_file = temporary.At("flags");
  std::ofstream(flag_file) << "not a flag\n";
  for (const auto& [flag, message] : {
           std::pair<std::string, std::string>("--adress=127.0.0.1:0", "'adress'"),
           {"--workers=two", "'two' specified for flag 'workers'"},
           {"--workers", "Missing the value for the flag 'workers'"},
           {"--fleet=maybe", "'maybe' specified for flag 'fleet'"},
           {"--drain_timeout=10", "allowed: a duration with its unit, such as 10s"},
           {"--flagfile=" + temporary.At("none"), "flagfile"},
           {"--flagfile=" + flag_file, "flagfile"},
           {"word", "'word' is not a flag"},
       }) {
    ServerProcess process({flag});
    EXPECT_EQ(process.Wait(), 2) << flag;
    EXPECT_THAT(process.rest(), HasSubstr(message)) << flag;
  }
}

TEST(BinaryTest, ArtDirIsDrawnAndReported) {
  const TemporaryFolder temporary;
  const std::string folder = temporary.At("art");
  PaintArtFolder(folder);
  ServerProcess plain({"--address=127.0.0.1:0"});
  ServerProcess painted({"--address=127.0.0.1:0", "--art_dir=" + folder});
  const std::string painted_address = painted.Address();
  std::filesystem::remove_all(folder);
  const std::string own = FirstPictureOf(plain.Address(), "built-in");
  const std::string other = FirstPictureOf(painted_address, "folder");
  EXPECT_EQ(own.size(), other.size());
  EXPECT_NE(own, other);
}

TEST(BinaryTest, ArtDirWithoutArtIsReported) {
  const TemporaryFolder temporary;
  const std::string folder = temporary.At("none");
  ServerProcess process({"--address=127.0.0.1:0", "--art_dir=" + folder});
  EXPECT_EQ(process.Wait(), 2);
  EXPECT_THAT(process.rest(),
              HasSubstr("--art_dir: art folder '" + folder + "': there is no such folder"));
}

TEST(BinaryTest, AddressInUseIsAnError) {
  ServerProcess first({"--address=127.0.0.1:0"});
  const std::string address = first.Address();
  ServerProcess second({"--address=" + address});
  EXPECT_EQ(second.Wait(), 1);
  EXPECT_THAT(second.rest(), HasSubstr("cannot listen on " + address));
}

TEST(BinaryTest, StatesAreClonedBetweenServers) {
  ServerProcess source_process({"--address=127.0.0.1:0", "--workers=1"});
  ServerProcess target_process({"--address=127.0.0.1:0", "--workers=3"});
  const std::string source_address = source_process.Address();
  const auto source_client = procgen_client::Client::Connect(source_address);
  const auto target_client = procgen_client::Client::Connect(target_process.Address());
  ASSERT_THAT(source_client, IsOk());
  ASSERT_THAT(target_client, IsOk());
  const auto source_pool = (*source_client)->CreatePool(MazeSpec(2), "origin");
  const auto target_pool = (*target_client)->CreatePool(MazeSpec(2));
  ASSERT_THAT(source_pool, IsOk());
  ASSERT_THAT(target_pool, IsOk());
  const auto source = (*source_client)->Attach(source_pool->name());
  const auto target = (*target_client)->Attach(target_pool->name());
  ASSERT_THAT(source, IsOk());
  ASSERT_THAT(target, IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*source)->Step({-1, 7}, &batch), IsOk());

  ASSERT_THAT((*target_client)
                  ->CloneStates(target_pool->name(), {Pair(0, 1), Pair(1, 0)},
                                {source_pool->name(), source_address}),
              IsOk());
  ASSERT_THAT((*target_client)->CloneStates(target_pool->name(), {Pair(0, 1), Pair(1, 0)}), IsOk());
  procgen_client::Batch target_batch;
  for (const int32_t action : {7, 1, -1, 7}) {
    ASSERT_THAT((*source)->Step({action, action}, &batch), IsOk());
    ASSERT_THAT((*target)->Step({action, action}, &target_batch), IsOk());
    EXPECT_EQ(BatchCopy(target_batch), BatchCopy(batch));
  }
}

TEST(BinaryTest, UnixSocketIsServed) {
  const TemporaryFolder temporary;
  const std::string address = "unix:" + temporary.At("socket");
  ServerProcess process({"--address=" + address});
  ASSERT_EQ(process.Address(), address);
  const auto client = procgen_client::Client::Connect(address);
  ASSERT_THAT(client, IsOk());
  EXPECT_THAT((*client)->GetCatalog(), IsOk());
}

}  // namespace
}  // namespace procgen
