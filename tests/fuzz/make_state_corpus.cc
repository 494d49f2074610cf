// procgen-make-state-corpus FOLDER: writes the seed inputs of state_fuzz to
// FOLDER/<game>_<mode>.pgst: a snapshot of every game in two modes, after some random steps.
// Overwrites existing files.

#include <fstream>
#include <iostream>
#include <memory>
#include <string>

#include "envcore/pool/pool.h"
#include "envcore/random/random_stream.h"

namespace {

using procgen::DistributionMode;
using procgen::GameSpec;

constexpr int kStepCount = 40;
constexpr int kBadUse = 2;

std::string SnapshotOf(const GameSpec& spec, DistributionMode mode) {
  procgen::PoolOptions options;
  options.games = {std::string(spec.name)};
  options.env_count = 1;
  options.environment.distribution_mode = mode;
  options.environment.rand_seed = 7;
  const auto pool =
      procgen::Pool::Create(options, std::make_shared<procgen::WorkerPool>(0)).value();
  procgen::RandomStream random(5);
  for (int step = 0; step < kStepCount; ++step) {
    const int32_t action = random.Int(procgen::kActionCount);
    pool->Step({.count = 1, .actions = {&action, 1}}, {}).IgnoreError();
  }
  return pool->SaveStates({0}).value().front();
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::cerr << "usage: procgen-make-state-corpus FOLDER\n";
    return kBadUse;
  }
  for (const GameSpec& spec : procgen::GameCatalog()) {
    for (const DistributionMode mode : {spec.modes.front(), spec.modes.back()}) {
      const std::string path = std::string(arguments[1]) + "/" + std::string(spec.name) + "_" +
                               std::string(procgen::DistributionModeName(mode)) + ".pgst";
      std::ofstream file(path, std::ios::binary);
      file << SnapshotOf(spec, mode);
      if (!file.flush()) {
        std::cerr << "procgen-make-state-corpus: cannot write " << path << "\n";
        return kBadUse;
      }
    }
  }
  return 0;
}
