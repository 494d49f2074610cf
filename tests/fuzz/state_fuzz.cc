// Fuzz target: restores bytes as a snapshot; if that succeeds, saves, draws and steps the
// environment. Aborts if a restored state cannot be saved, or changes when it is restored again or
// converted to JSON and back, if it cannot be saved and restored after some steps, or if equal
// steps from one snapshot give different observations or states.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "envcore/environment/readable_state.h"
#include "envcore/pool/pool.h"
#include "envcore/random/random_stream.h"

namespace procgen {
namespace {

constexpr int kStepCount = 24;
constexpr int kStepsBetweenPictures = 8;
constexpr int32_t kRenderedSizePx = 80;

void Require(bool holds, absl::string_view claim, const absl::Status& status = absl::OkStatus()) {
  if (!holds) {
    std::cerr << "state_fuzz: " << claim << ": " << status << std::endl;
    std::abort();
  }
}

std::unique_ptr<Pool> MadePool(const GameSpec& spec) {
  PoolOptions options;
  options.games = {std::string(spec.name)};
  options.env_count = 1;
  auto pool = Pool::Create(options, std::make_shared<WorkerPool>(0));
  Require(pool.ok(), "there is no pool to restore in", pool.status());
  return *std::move(pool);
}

// A pool of the game that the CBOR text of `snapshot` names; of an arbitrary game without one.
Pool& PoolFor(absl::string_view snapshot) {
  static const auto& pools = *[] {
    auto* made = new std::vector<std::unique_ptr<Pool>>;
    for (const GameSpec& spec : GameCatalog()) {
      made->push_back(MadePool(spec));
    }
    return made;
  }();
  const absl::Span<const GameSpec> games = GameCatalog();
  for (size_t i = 0; i < games.size(); ++i) {
    // In CBOR a short text is 0x60 plus its length, then the text: "d" and "game".
    const char text_of_length = static_cast<char>(0x60 + games[i].name.size());
    const std::string field = absl::StrCat("dgame", std::string(1, text_of_length), games[i].name);
    if (absl::StrContains(snapshot, field)) {
      return *pools[i];
    }
  }
  return *pools[snapshot.size() % pools.size()];
}

std::string Saved(Pool& pool, absl::string_view claim) {
  auto snapshots = pool.SaveStates({0});
  Require(snapshots.ok(), claim, snapshots.status());
  return snapshots->front();
}

// The results of some steps.
struct Played {
  std::vector<float> rewards;
  std::vector<uint64_t> fingerprints;
  std::vector<uint8_t> pictures;
  std::string snapshot;

  bool operator==(const Played& other) const {
    return rewards == other.rewards && fingerprints == other.fingerprints &&
           pictures == other.pictures && snapshot == other.snapshot;
  }
};

Played PlayOn(Pool& pool, int64_t seed) {
  Played played;
  RandomStream random(seed);
  std::vector<uint8_t> picture(kObservationBytes);
  for (int step = 0; step < kStepCount; ++step) {
    const int32_t action = random.Int(kActionCount);
    Batch batch;
    batch.rewards = absl::MakeSpan(&played.rewards.emplace_back(), 1);
    batch.fingerprints = absl::MakeSpan(&played.fingerprints.emplace_back(), 1);
    batch.final_observations = absl::MakeSpan(picture);
    if (step % kStepsBetweenPictures == 0) {
      batch.observations = absl::MakeSpan(picture);
    }
    const absl::Status status = pool.Step({.count = 1, .actions = {&action, 1}}, batch);
    if (status.code() == absl::StatusCode::kFailedPrecondition) {
      break;  // the snapshot's autoreset_mode is "disabled", and an episode has ended
    }
    Require(status.ok(), "cannot step", status);
    played.pictures.insert(played.pictures.end(), picture.begin(), picture.end());
  }
  std::vector<uint8_t> rendered(static_cast<size_t>(kRenderedSizePx) * kRenderedSizePx * 3);
  const absl::Status status = pool.Render(0, kRenderedSizePx, absl::MakeSpan(rendered));
  Require(status.ok(), "cannot render", status);
  played.pictures.insert(played.pictures.end(), rendered.begin(), rendered.end());
  played.snapshot = Saved(pool, "cannot be saved after some steps");
  return played;
}

void Restore(Pool& pool, absl::string_view snapshot, absl::string_view claim) {
  const absl::Status status = pool.RestoreStates({{0, snapshot}});
  Require(status.ok(), claim, status);
}

void TryToRestore(absl::string_view snapshot) {
  Pool& pool = PoolFor(snapshot);
  const absl::Status status = pool.RestoreStates({{0, snapshot}});
  if (!status.ok()) {
    // FAILED_PRECONDITION: the snapshot names a second game, which the pool does not play.
    Require(status.code() == absl::StatusCode::kInvalidArgument ||
                status.code() == absl::StatusCode::kFailedPrecondition ||
                status.code() == absl::StatusCode::kDataLoss,
            "rejected with an undocumented code", status);
    return;
  }
  const std::string saved = Saved(pool, "what was restored cannot be saved");
  Restore(pool, saved, "what was restored and saved cannot be restored");
  Require(Saved(pool, "cannot save again") == saved, "the snapshot of a restored one differs");
  const auto json = SnapshotToJson(saved);
  Require(json.ok(), "what was restored and saved has no JSON", json.status());
  const auto from_json = SnapshotFromJson(*json);
  Require(from_json.ok(), "the JSON of a snapshot is rejected", from_json.status());
  Require(*from_json == saved, "the JSON of a snapshot gives another one");

  const auto seed = static_cast<int64_t>(snapshot.size());
  const Played played = PlayOn(pool, seed);
  Restore(pool, saved, "what was restored before cannot be restored again");
  Require(PlayOn(pool, seed) == played, "the same steps from the same snapshot differ");
  Restore(pool, played.snapshot, "what was saved after some steps cannot be restored");
  Require(Saved(pool, "cannot save again") == played.snapshot, "the snapshot after steps differs");
}

}  // namespace
}  // namespace procgen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  procgen::TryToRestore(absl::string_view(reinterpret_cast<const char*>(bytes), size));
  return 0;
}
