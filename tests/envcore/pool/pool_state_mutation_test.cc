// Sets every field of a snapshot to extreme values, for every game in each of its modes. The
// snapshot is either rejected with a reason and changes nothing, or the environment can be stepped,
// drawn, saved and restored. Under the sanitizers, this shows whether a snapshot can break the
// engine.

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/pool/pool.h"
#include "envcore/random/random_stream.h"
#include "envcore/state/snapshot_frame.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/envcore/pool/small_pool.h"
#include "tests/fuzz/snapshot_mutation.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using ::testing::AnyOf;
using Json = nlohmann::ordered_json;
using Pointer = Json::json_pointer;

constexpr int kStepsBefore = 30;
constexpr uint32_t kMutantCount = 300;  // per game and mode
#if defined(__SANITIZE_ADDRESS__)
constexpr int kStepsAfter = 200;
#elif defined(__SANITIZE_THREAD__)
// ThreadSanitizer looks for races, which a single thread does not have.
constexpr int kStepsAfter = 5;
#else
// Without a sanitizer, only crashes and failed checks are found.
constexpr int kStepsAfter = 40;
#endif
constexpr int kStepsBetweenPictures = 25;

Json Decoded(const std::string& snapshot) {
  return Json::from_cbor(snapshot.substr(kSnapshotHeaderBytes));
}

std::string Encoded(const Json& tree) {
  std::string body;
  Json::to_cbor(tree, body);
  return FrameSnapshot(body);
}

// The fields of a tree; of a list only those of the first and the last entry.
// NOLINTNEXTLINE(misc-no-recursion): as deep as a snapshot
void CollectFields(const Json& node, const Pointer& path, std::vector<Pointer>* fields) {
  if (!path.empty()) {
    fields->push_back(path);
  }
  if (node.is_object()) {
    for (const auto& [name, value] : node.items()) {
      CollectFields(value, path / name, fields);
    }
  } else if (node.is_array() && !node.empty()) {
    CollectFields(node.front(), path / 0, fields);
    if (node.size() > 1) {
      CollectFields(node.back(), path / (node.size() - 1), fields);
    }
  }
}

// The values to set a field of the type of `value` to.
std::vector<Json> ExtremesOf(const Json& value) {
  if (value.is_boolean()) {
    return {!value.get<bool>(), 1};
  }
  if (value.is_number_float()) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    std::vector<Json> extremes = {std::nanf(""), -0.0F, "0.5"};
    for (const float extreme : {1e-30F, 0.5F, 1.0F, 1.5F, 8.0F, 256.0F, 1000.0F, 1e6F,
                                std::numeric_limits<float>::max(), kInfinity}) {
      extremes.emplace_back(extreme);
      extremes.emplace_back(-extreme);
    }
    return extremes;
  }
  if (value.is_number()) {
    return {std::numeric_limits<int64_t>::min(),
            std::numeric_limits<int32_t>::min(),
            -1000000,
            -1,
            0,
            1,
            2,
            8,
            51,
            54,
            99,
            100,
            1000,
            1000000,
            1 << 30,
            std::numeric_limits<int32_t>::max(),
            std::numeric_limits<uint64_t>::max(),
            0.5};
  }
  if (value.is_array() && !value.empty()) {
    Json shorter = value;
    shorter.erase(shorter.size() - 1);
    Json longer = value;
    longer.push_back(value.back());
    Json long_list = value;
    while (long_list.size() < 3000) {
      long_list.push_back(value.back());
    }
    return {Json::array(), shorter, longer, long_list, Json::object()};
  }
  return {Json::object(), Json::array(), "", "maze", 0};
}

// Plays and saves repeatedly. The last snapshot can be restored, and saving again gives the same
// bytes.
void PlayOn(Pool& pool, int steps) {
  RandomStream random(3);
  std::vector<uint8_t> picture(kObservationBytes);
  std::vector<uint8_t> final_picture(kObservationBytes);
  for (int step = 0; step < steps; ++step) {
    const int32_t action = random.Int(kActionCount);
    Batch batch;
    batch.final_observations = absl::MakeSpan(final_picture);
    if (step % kStepsBetweenPictures == 0) {
      batch.observations = absl::MakeSpan(picture);
    }
    ASSERT_THAT(pool.Step({.count = 1, .actions = {&action, 1}}, batch), IsOk());
    if (step % kStepsBetweenPictures == 0) {
      ASSERT_THAT(pool.SaveStates({0}), IsOk());
    }
  }
  const auto saved = pool.SaveStates({0});
  ASSERT_THAT(saved, IsOk());
  ASSERT_THAT(pool.RestoreStates({{0, saved->front()}}), IsOk());
  EXPECT_EQ(pool.SaveStates({0}).value(), *saved);
}

struct Played {
  std::string name;
  PoolOptions options;
};

// Every game in its first mode (`is_first`), or in each of its other modes.
std::vector<Played> GamesInModes(bool is_first) {
  std::vector<Played> all;
  for (const GameSpec& game : GameCatalog()) {
    for (const DistributionMode mode : game.modes) {
      if ((mode == game.modes.front()) != is_first) {
        continue;
      }
      PoolOptions options = OptionsOf({std::string(game.name)}, 1);
      options.environment.distribution_mode = mode;
      options.environment.rand_seed = 4;
      options.autoreset_mode = AutoresetMode::kNextStep;
      all.push_back({absl::StrCat(game.name, "_", DistributionModeName(mode)), options});
    }
  }
  return all;
}

class PoolStateMutationTest : public ::testing::TestWithParam<Played> {
 protected:
  // Restores `tree`. If that succeeds, plays on. Then restores `snapshot`.
  static void Try(Pool& pool, const std::string& snapshot, const Json& tree) {
    const std::string mutant = Encoded(tree);
    const absl::Status status = pool.RestoreStates({{0, mutant}});
    if (!status.ok()) {
      EXPECT_THAT(status.code(),
                  AnyOf(absl::StatusCode::kInvalidArgument, absl::StatusCode::kDataLoss,
                        absl::StatusCode::kFailedPrecondition))
          << status;
      EXPECT_EQ(pool.SaveStates({0}).value()[0], snapshot);
      return;
    }
    PlayOn(pool, kStepsAfter);
    ASSERT_THAT(pool.RestoreStates({{0, snapshot}}), IsOk());
  }
};

// A snapshot of a level after some steps.
std::string PlayedSnapshot(Pool& pool) {
  RandomStream random(8);
  for (int step = 0; step < kStepsBefore; ++step) {
    const int32_t action = random.Int(kActionCount);
    EXPECT_THAT(pool.Step({.count = 1, .actions = {&action, 1}}, {}), IsOk());
  }
  return pool.SaveStates({0}).value()[0];
}

TEST_P(PoolStateMutationTest, AcceptedSnapshotsCanBeSavedAndRestoredAfterAnySteps) {
  const std::unique_ptr<Pool> pool = MadePool(GetParam().options);
  const std::string snapshot = PlayedSnapshot(*pool);
  int taken_count = 0;
  for (uint32_t seed = 0; seed < kMutantCount; ++seed) {
    SCOPED_TRACE(seed);
    const std::string mutant = MutatedSnapshot(snapshot, seed, kSnapshotBytesMax);
    if (pool->RestoreStates({{0, mutant}}).ok()) {
      ++taken_count;
      PlayOn(*pool, static_cast<int>(seed % kStepsAfter) + 1);
    }
  }
  EXPECT_GT(taken_count, 0);
}

TEST_P(PoolStateMutationTest, ExtremeValuesAreRejectedOrPlayable) {
  const std::unique_ptr<Pool> pool = MadePool(GetParam().options);
  const std::string snapshot = PlayedSnapshot(*pool);
  const Json tree = Decoded(snapshot);
  ASSERT_EQ(Encoded(tree), snapshot);
  std::vector<Pointer> fields;
  CollectFields(tree, Pointer(), &fields);
  for (const Pointer& field : fields) {
    SCOPED_TRACE(field.to_string());
    for (const Json& extreme : ExtremesOf(tree.at(field))) {
      Json mutant = tree;
      mutant[field] = extreme;
      Try(*pool, snapshot, mutant);
    }
    Json without = tree;
    Json& group = without[field.parent_pointer()];
    if (group.is_object()) {
      group.erase(field.back());
      Try(*pool, snapshot, without);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(EveryGame, PoolStateMutationTest,
                         ::testing::ValuesIn(GamesInModes(/*is_first=*/true)),
                         [](const auto& info) { return info.param.name; });
// Has the label slow.
INSTANTIATE_TEST_SUITE_P(OtherModes, PoolStateMutationTest,
                         ::testing::ValuesIn(GamesInModes(/*is_first=*/false)),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace procgen
