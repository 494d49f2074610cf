#include "tests/service/scripted_learner.h"

#include <algorithm>
#include <memory>
#include <random>
#include <utility>

#include "absl/hash/hash.h"

namespace procgen {
namespace {

using procgen_client::Batch;
using procgen_client::Client;
using procgen_client::StepStream;

constexpr int32_t kActionCount = 15;
constexpr int32_t kLevelSeeds = 1000;

// Hash of all fields of a batch. Comparable within one process only.
uint64_t HashOfBatch(const Batch& batch) {
  return absl::HashOf(batch.first_env(), batch.env_count(), batch.observations(), batch.rewards(),
                      batch.first(), batch.terminated(), batch.truncated(), batch.level_seeds(),
                      batch.prev_level_seeds(), batch.prev_level_complete(),
                      batch.episode_returns(), batch.episode_lengths(), batch.fingerprints(),
                      batch.final_observations());
}

// Executes a LearnerScript.
class Player {
 public:
  Player(const LearnerScript& script, Client* client) : script_(script), client_(client) {
    random_.seed(script.seed);
  }

  absl::Status Begin() {
    const absl::StatusOr<v1::Pool> pool = client_->CreatePool(script_.spec);
    if (!pool.ok()) {
      return pool.status();
    }
    pool_ = pool->name();
    env_count_ = pool->spec().env_count();
    over_.assign(static_cast<size_t>(env_count_), false);
    auto stream = client_->Attach(pool_);
    if (!stream.ok()) {
      return stream.status();
    }
    stream_ = *std::move(stream);
    return stream_->Observe(&batch_);
  }

  // Sends one random request; returns the hash of its response.
  absl::StatusOr<uint64_t> Play() {
    absl::Status status;
    const uint32_t kind = Draw(100);
    if (kind < 4) {
      status = Reset();
    } else if (kind < 6) {
      status = stream_->Observe(&batch_);
    } else if (kind < 7) {
      status = Sample();
    } else if (kind < 10 && script_.with_states) {
      status = States();
    } else {
      status = Step();
    }
    if (!status.ok()) {
      return status;
    }
    return HashOfBatch(batch_);
  }

  absl::Status End() {
    if (absl::Status status = stream_->Close(); !status.ok()) {
      return status;
    }
    return client_->DeletePool(pool_);
  }

 private:
  uint32_t Draw(uint32_t below) { return static_cast<uint32_t>(random_() % below); }
  int32_t DrawEnvironment() {
    return static_cast<int32_t>(Draw(static_cast<uint32_t>(env_count_)));
  }
  int32_t DrawLevel() { return static_cast<int32_t>(Draw(kLevelSeeds)); }

  v1::Slice DrawSlice() {
    v1::Slice slice;
    if (Draw(3) == 0) {
      const int32_t first = DrawEnvironment();
      slice.set_first_env(first);
      slice.set_env_count(1 +
                          static_cast<int32_t>(Draw(static_cast<uint32_t>(env_count_ - first))));
    } else {
      slice.set_env_count(env_count_);
    }
    return slice;
  }

  absl::Status Call(v1::StepPoolRequest request) {
    absl::Status status = stream_->Call(std::move(request), &batch_);
    for (int32_t row = 0; status.ok() && row < batch_.env_count(); ++row) {
      const auto at = static_cast<size_t>(row);
      over_[static_cast<size_t>(batch_.first_env()) + at] =
          batch_.terminated()[at] || batch_.truncated()[at];
    }
    return status;
  }

  void FillReset(int32_t environment, v1::Reset* reset) {
    reset->set_environment(environment);
    if (Draw(2) == 0) {
      reset->set_level_seed(DrawLevel());
    }
    if (Draw(4) == 0) {
      reset->set_rand_seed(DrawLevel());
    }
  }

  absl::Status Step() {
    v1::StepPoolRequest request;
    v1::Step* step = request.mutable_step();
    *step->mutable_slice() = DrawSlice();
    const int32_t first = step->slice().first_env();
    const int32_t count = step->slice().env_count();
    const uint32_t odd = Draw(40);
    for (int32_t i = 0; i < count; ++i) {
      const bool ends = odd == 0 && Draw(8) == 0;
      step->add_actions(ends ? -1 : static_cast<int32_t>(Draw(kActionCount)));
    }
    step->set_repeat_count(odd < 6 ? 1 + static_cast<int32_t>(Draw(4)) : 0);
    step->set_observation(odd > 30 ? v1::OBSERVATION_NONE : v1::OBSERVATION_FRAME);
    step->set_with_final_observations(odd % 5 == 0);
    step->set_chunk_count(odd % 7 == 0 ? 3 : 0);
    if (odd % 4 == 0) {
      v1::NextLevel* next = step->add_next_levels();
      next->set_environment(first + static_cast<int32_t>(Draw(static_cast<uint32_t>(count))));
      next->set_level_seed(DrawLevel());
    }
    const bool must_reset = script_.spec.autoreset_mode() == v1::AUTORESET_MODE_DISABLED;
    for (int32_t i = first; i < first + count; ++i) {
      if ((must_reset && over_[static_cast<size_t>(i)]) || (odd == 9 && Draw(10) == 0)) {
        FillReset(i, step->add_resets());
      }
    }
    return Call(std::move(request));
  }

  absl::Status Reset() {
    v1::StepPoolRequest request;
    *request.mutable_reset()->mutable_slice() = DrawSlice();
    const v1::Slice& slice = request.reset().slice();
    const auto count = static_cast<uint32_t>(slice.env_count());
    FillReset(slice.first_env() + static_cast<int32_t>(Draw(count)),
              request.mutable_reset()->add_resets());
    return Call(std::move(request));
  }

  absl::Status Sample() {
    v1::LevelSampler sampler;
    for (int i = 0; i < 20; ++i) {
      sampler.add_level_seeds(DrawLevel());
      sampler.add_weights(static_cast<float>(1 + Draw(9)));
    }
    sampler.set_rand_seed(DrawLevel());
    return stream_->SetLevelSampler(sampler);
  }

  // Saves an environment, restores a saved state, or clones.
  absl::Status States() {
    const auto games = static_cast<uint32_t>(script_.spec.games_size());
    absl::Status status;
    if (Draw(3) == 0) {
      // A target with the same game: games are assigned round-robin.
      v1::ClonePair pair;
      pair.set_source_environment(DrawEnvironment());
      const uint32_t turns = static_cast<uint32_t>(env_count_) / games;
      pair.set_target_environment(static_cast<int32_t>(
          (static_cast<uint32_t>(pair.source_environment()) + games * Draw(turns)) %
          (games * turns)));
      status = client_->CloneStates(pool_, {&pair, 1});
    } else if (saved_.empty() || Draw(2) == 0) {
      const int32_t environments[] = {DrawEnvironment()};
      auto states = client_->SaveStates(pool_, environments);
      status = states.status();
      if (status.ok()) {
        saved_.insert(saved_.end(), states->begin(), states->end());
      }
    } else {
      status =
          client_->RestoreStates(pool_, {&saved_[Draw(static_cast<uint32_t>(saved_.size()))], 1});
    }
    if (!status.ok()) {
      return status;
    }
    v1::StepPoolRequest request;
    request.mutable_observe();
    return Call(std::move(request));
  }

  const LearnerScript script_;
  Client* const client_;
  std::mt19937 random_;
  std::string pool_;
  int32_t env_count_ = 0;
  std::unique_ptr<StepStream> stream_;
  Batch batch_;
  std::vector<bool> over_;  // by environment: its episode ended in the last step
  std::vector<v1::State> saved_;
};

}  // namespace

absl::StatusOr<LearnerTrace> PlayScript(const LearnerScript& script, Client* client,
                                        const std::function<void(int index)>& before_request) {
  Player player(script, client);
  if (absl::Status status = player.Begin(); !status.ok()) {
    return status;
  }
  LearnerTrace trace;
  for (int i = 0; i < script.request_count; ++i) {
    before_request(i);
    const absl::StatusOr<uint64_t> hash = player.Play();
    if (!hash.ok()) {
      return hash.status();
    }
    trace.push_back(*hash);
  }
  if (absl::Status status = player.End(); !status.ok()) {
    return status;
  }
  return trace;
}

int FirstDifference(const LearnerTrace& left, const LearnerTrace& right) {
  const auto [at, other] = std::mismatch(left.begin(), left.end(), right.begin(), right.end());
  return at == left.end() && other == right.end() ? -1 : static_cast<int>(at - left.begin());
}

}  // namespace procgen
