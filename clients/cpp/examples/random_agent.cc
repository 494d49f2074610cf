// A random agent: random_agent localhost:50051 coinrun
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "procgen_client/client.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: random_agent SERVER GAME\n";
    return 2;
  }
  auto client = procgen_client::Client::Connect(argv[1]).value();
  procgen::v1::PoolSpec spec;
  spec.add_games(argv[2]);
  spec.set_env_count(64);
  const std::string pool = client->CreatePool(spec)->name();
  auto stream = client->Attach(pool).value();
  std::mt19937 random;
  std::vector<int32_t> actions(64);
  procgen_client::Batch batch;
  size_t episodes = 0;
  for (int step = 0; step < 1000 && stream->Step(actions, &batch).ok(); ++step) {
    episodes += batch.fingerprints().size();  // One for each episode that ended.
    for (int32_t& action : actions) {
      action = static_cast<int32_t>(random() % 15);
    }
  }
  std::cout << episodes << " episodes of " << argv[2] << "\n";
  return client->DeletePool(pool).ok() ? 0 : 1;
}
