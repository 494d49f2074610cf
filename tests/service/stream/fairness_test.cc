// Owners share the server's background threads fairly.

#include <atomic>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/rpc/server.h"
#include "tests/service/pool_stream.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

constexpr char kAliceToken[] = "alice-token-0123456789";
constexpr char kBobToken[] = "bob-token-01234567890123";

TEST(FairnessTest, ManyRenderingsOfOneOwnerDoNotDelayOthers) {
  constexpr int kStreamCount = 20;
  constexpr int kRenderCount = 2;  // per stream
  const TemporaryFolder folder;
  std::ofstream(folder.At("tokens")) << "alice " << kAliceToken << "\nbob " << kBobToken << "\n";
  auto tokens = TokenFile::Open(folder.At("tokens"));
  ASSERT_THAT(tokens, IsOk());
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.tokens = *std::move(tokens);
  const auto server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  const auto channel = ChannelTo((*server)->address());

  v1::RunPoolRequest render;
  render.mutable_render()->set_format(v1::FRAME_FORMAT_PNG);
  render.mutable_render()->mutable_environments()->Resize(4, 0);
  std::vector<std::unique_ptr<PoolStream>> runs(kStreamCount);
  for (std::unique_ptr<PoolStream>& run : runs) {
    run = std::make_unique<PoolStream>(channel, kAliceToken);
    ASSERT_THAT(run->Start(MazeSpec(1)), IsOk());
  }
  std::atomic<int> answered = 0;
  absl::Notification first_answered;
  std::vector<std::thread> threads;
  threads.reserve(kStreamCount);
  for (const std::unique_ptr<PoolStream>& run : runs) {
    for (int i = 0; i < kRenderCount; ++i) {
      run->Write(render);
    }
    threads.emplace_back([&] {
      for (int i = 0; i < kRenderCount; ++i) {
        EXPECT_THAT(run->Read(), IsOk());
        if (answered++ == 0) {
          first_answered.Notify();
        }
      }
    });
  }
  first_answered.WaitForNotification();
  PoolStream bob(channel, kBobToken);
  EXPECT_THAT(bob.Start(MazeSpec(1)), IsOk());
  EXPECT_THAT(bob.Save(), IsOk());
  EXPECT_LT(answered, kStreamCount * kRenderCount * 3 / 4);
  for (std::thread& thread : threads) {
    thread.join();
  }
}

}  // namespace
}  // namespace procgen
