// A random agent: random_agent localhost:50051 coinrun
#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <vector>

#include "procgen_client/servers.h"

int main(int argc, char** argv) {
  auto servers = procgen_client::Servers::Connect(argc > 1 ? argv[1] : "localhost:50051").value();
  procgen::PoolOptions options;
  options.games = {argc > 2 ? argv[2] : "coinrun"};
  options.env_count = 64;
  auto pool = procgen_client::CreatePool(servers, options).value();
  std::vector<int32_t> actions(64);
  std::vector<uint8_t> first(64);
  procgen::Batch batch;
  batch.first = absl::MakeSpan(first);
  int64_t episodes = 0;
  for (int i = 0; i < 1000 && pool->Step({.count = 64, .actions = actions}, {}, batch).ok(); ++i) {
    episodes += std::count(first.begin(), first.end(), 1);
    std::generate(actions.begin(), actions.end(), [] { return std::rand() % 15; });
  }
  std::cout << episodes << " episodes of " << options.games.front() << "\n";
}
