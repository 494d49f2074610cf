// procgen-server as a program: flags, startup and shutdown.

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/envcore/pool/painted_art.h"
#include "tests/service/pool_stream.h"
#include "tests/service/server_process.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

using testing::HasSubstr;

class SignalTest : public testing::TestWithParam<int> {};

// Steps until the server drains; returns the number of steps.
int StepUntilItDrains(PoolStream* run) {
  v1::Batch batch;
  int count = 0;
  absl::Status status = run->Step({4, 4, 4, 4}, &batch);
  for (; status.ok(); ++count) {
    status = run->Step({4, 4, 4, 4}, &batch);
  }
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kUnavailable, HasSubstr("drains")));
  EXPECT_TRUE(run->drained());
  return count;
}

TEST_P(SignalTest, DrainsAndExitsWithZero) {
  ServerProcess process({"--address=127.0.0.1:0", "--workers=2"});
  PoolStream run(ChannelTo(process.Address()));
  ASSERT_THAT(run.Start(MazeSpec(4)), IsOk());
  v1::Batch batch;
  ASSERT_THAT(run.Step({4, 4, 4, 4}, &batch), IsOk());
  process.Signal(GetParam());
  StepUntilItDrains(&run);
  EXPECT_EQ(process.Wait(), 0);
  EXPECT_THAT(process.rest(), HasSubstr("event=draining"));
  EXPECT_THAT(process.rest(), HasSubstr("event=stopped"));
}

INSTANTIATE_TEST_SUITE_P(Signals, SignalTest, testing::Values(SIGTERM, SIGINT));

TEST(DrainingTest, IdleConnectionsDoNotDelayDrain) {
  ServerProcess process({"--address=127.0.0.1:0"});
  const auto client = procgen_client::Client::Connect(process.Address());
  ASSERT_THAT(client, IsOk());
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
  PoolStream run(ChannelTo(address));
  EXPECT_THAT(run.Start(MazeSpec(1)), IsOk());
  v1::Batch batch;
  EXPECT_THAT(run.Observe(&batch), IsOk());
  return batch.observations();
}

TEST(BinaryTest, HelpListsTheFlags) {
  ServerProcess process({"--help"});
  EXPECT_EQ(process.Wait(), 0);
  for (const char* flag :
       {"--address", "--workers", "--env_count_max", "--request_bytes_max", "--art_dir",
        "--log_level", "--tls_certificate", "--tokens", "--allow_insecure", "--owner_env_count_max",
        "--keepalive_time", "--keepalive_timeout", "--metrics_address", "--web_address"}) {
    EXPECT_THAT(process.rest(), HasSubstr(flag));
  }
}

TEST(BinaryTest, FlagsThatCannotBeParsedExitWithTwo) {
  const TemporaryFolder temporary;
  const std::string flag_file = temporary.At("flags");
  std::ofstream(flag_file) << "not a flag\n";
  for (const auto& [flag, message] : {
           std::pair<std::string, std::string>("--adress=127.0.0.1:0", "'adress'"),
           {"--workers=two", "'two' specified for flag 'workers'"},
           {"--workers", "Missing the value for the flag 'workers'"},
           {"--allow_insecure=maybe", "'maybe' specified for flag 'allow_insecure'"},
           {"--keepalive_time=10", "'10' specified for flag 'keepalive_time'"},
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

TEST(BinaryTest, AddressInUseIsAnError) {
  ServerProcess first({"--address=127.0.0.1:0"});
  const std::string address = first.Address();
  ServerProcess second({"--address=" + address});
  EXPECT_EQ(second.Wait(), 1);
  EXPECT_THAT(second.rest(), HasSubstr("cannot listen on " + address));
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
