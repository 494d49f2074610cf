// procgen-make-batch-corpus FOLDER: writes the seed inputs of batch_fuzz to FOLDER/batch: valid
// responses, raw and encoded, without and with ended episodes. Overwrites existing files.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "procgen/v1/run.pb.h"
#include "server/encoding/observation_encoder.h"

namespace procgen {
namespace {

constexpr int kBadUse = 2;
// As in batch_fuzz.cc.
constexpr int32_t kFuzzedEnvCount = 3;
constexpr size_t kFuzzedObservationBytes = 16 * 16 * 3;
constexpr size_t kBytes = kFuzzedEnvCount * kFuzzedObservationBytes;

v1::RunPoolResponse Response(bool is_encoded, bool ends) {
  v1::RunPoolResponse response;
  v1::Batch& batch = *response.mutable_batch();
  batch.set_env_count(kFuzzedEnvCount);
  batch.mutable_rewards()->Resize(kFuzzedEnvCount, 1);
  batch.mutable_first()->Resize(kFuzzedEnvCount, ends);
  batch.mutable_terminated()->Resize(kFuzzedEnvCount, ends);
  batch.mutable_truncated()->Resize(kFuzzedEnvCount, false);
  batch.mutable_level_seeds()->Resize(kFuzzedEnvCount, 5);
  batch.mutable_prev_level_seeds()->Resize(kFuzzedEnvCount, 4);
  batch.mutable_prev_level_complete()->Resize(kFuzzedEnvCount, ends);
  batch.mutable_episode_returns()->Resize(kFuzzedEnvCount, 3);
  batch.mutable_episode_lengths()->Resize(kFuzzedEnvCount, 9);
  if (ends) {
    batch.mutable_fingerprints()->Resize(kFuzzedEnvCount, 7);
    batch.set_final_observations(std::string(kBytes, 'f'));
  }
  const std::vector<uint8_t> observations(kBytes, 'o');
  if (is_encoded) {
    ObservationEncoder encoder(kFuzzedEnvCount, kFuzzedObservationBytes);
    batch.set_observations(encoder.Encode(0, kFuzzedEnvCount, observations));
  } else {
    batch.set_observations(observations.data(), observations.size());
  }
  return response;
}

bool Write(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file << bytes;
  return static_cast<bool>(file.flush());
}

bool WriteBatches(const std::filesystem::path& folder) {
  bool is_written = true;
  for (const bool is_encoded : {false, true}) {
    for (const bool ends : {false, true}) {
      const std::string name = std::string(is_encoded ? "zstd" : "raw") + (ends ? "_ended" : "");
      const std::string choice(1, static_cast<char>(is_encoded));
      is_written &= Write(folder / name, choice + Response(is_encoded, ends).SerializeAsString());
    }
  }
  return is_written;
}

}  // namespace
}  // namespace procgen

int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::cerr << "usage: procgen-make-batch-corpus FOLDER\n";
    return procgen::kBadUse;
  }
  const std::filesystem::path folder = arguments[1];
  if (!procgen::WriteBatches(folder / "batch")) {
    std::cerr << "procgen-make-batch-corpus: cannot write in " << folder << "\n";
    return procgen::kBadUse;
  }
  return 0;
}
