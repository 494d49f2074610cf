// A random agent: random_agent localhost:50051 coinrun
#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "procgen_client/client.h"

int main(int argc, char** argv) {
  const std::string game = argc > 2 ? argv[2] : "coinrun";
  auto client = procgen_client::Client::Connect(argc > 1 ? argv[1] : "localhost:50051").value();
  procgen::v1::PoolSpec spec;
  spec.add_games(game);
  spec.set_env_count(64);
  auto stream = client->Attach(client->CreatePool(spec)->name()).value();
  std::vector<int32_t> actions(64);
  procgen_client::Batch batch;
  size_t episodes = 0;
  for (int step = 0; step < 1000 && stream->Step(actions, &batch).ok(); ++step) {
    episodes += batch.fingerprints().size();  // One for each episode that ended.
    std::generate(actions.begin(), actions.end(), [] { return std::rand() % 15; });
  }
  std::cout << episodes << " episodes of " << game << "\n";
  return client->DeletePool(stream->pool().name()).ok() ? 0 : 1;
}
