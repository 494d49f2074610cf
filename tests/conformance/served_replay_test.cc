// Observations drawn with the art of Procgen 0.10.7 by a server that was started with it.

#include <memory>
#include <string>
#include <vector>

#include "envcore/trace/trace.h"
#include "gtest/gtest.h"
#include "procgen_client/servers.h"
#include "server/rpc/server.h"
#include "tests/conformance/recordings.h"
#include "tests/status_matchers.h"
#include "tools/conformance/replay.h"

namespace procgen {
namespace {

class ServedReplayTest : public testing::TestWithParam<std::string> {};

TEST_P(ServedReplayTest, ObservationsMatchWithUpstreamArt) {
  const std::vector<std::string> paths = TracesOf(GetParam(), ReferenceFolder() + "/pixels");
  if (paths.empty() || UpstreamArtFolder().empty()) {
    GTEST_SKIP() << "no upstream art, or no recordings of it, next to the checkout";
  }
  const auto art = SharedArt::LoadFolder(UpstreamArtFolder());
  ASSERT_THAT(art, IsOk());
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.art = *art;
  const auto server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  const auto servers = procgen_client::Servers::Connect((*server)->address());
  ASSERT_THAT(servers, IsOk());
  for (const std::string& path : paths) {
    const auto trace = ReadTrace(path);
    ASSERT_THAT(trace, IsOk());
    const auto pool = procgen_client::CreatePool(*servers, PoolOptionsOf(*trace));
    ASSERT_THAT(pool, IsOk());
    EXPECT_EQ(FirstDifference(*trace, **pool, true), "") << path;
  }
}

INSTANTIATE_TEST_SUITE_P(Catalog, ServedReplayTest, testing::ValuesIn(GamesOfTheCatalog()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace procgen
