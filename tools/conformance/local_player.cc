#include "envcore/pool/pool.h"
#include "tools/conformance/player.h"

namespace procgen {
namespace {

class LocalPlayer final : public Player {
 public:
  LocalPlayer(std::unique_ptr<Pool> pool, bool with_pictures)
      : pool_(std::move(pool)), with_pictures_(with_pictures) {}

  absl::Status Observe(Observations* observed) override {
    return pool_->Observe(0, pool_->env_count(), Arrays(observed));
  }

  absl::Status Step(absl::Span<const int32_t> actions, Observations* observed) override {
    return pool_->Step({.count = pool_->env_count(), .actions = actions}, Arrays(observed));
  }

 private:
  Batch Arrays(Observations* observed) const {
    return BatchOf(observed, pool_->env_count(), with_pictures_);
  }

  std::unique_ptr<Pool> pool_;
  bool with_pictures_;
};

}  // namespace

Batch BatchOf(Observations* observed, int32_t env_count, bool with_pictures) {
  const auto count = static_cast<size_t>(env_count);
  observed->rewards.resize(count);
  observed->first.resize(count);
  observed->level_seeds.resize(count);
  observed->prev_level_seeds.resize(count);
  observed->prev_level_complete.resize(count);
  observed->observations.resize(with_pictures ? count * kObservationBytes : 0);
  Batch batch;
  batch.rewards = absl::MakeSpan(observed->rewards);
  batch.first = absl::MakeSpan(observed->first);
  batch.level_seeds = absl::MakeSpan(observed->level_seeds);
  batch.prev_level_seeds = absl::MakeSpan(observed->prev_level_seeds);
  batch.prev_level_complete = absl::MakeSpan(observed->prev_level_complete);
  batch.observations = absl::MakeSpan(observed->observations);
  return batch;
}

PoolOptions PoolOptionsOf(const Trace& trace) {
  PoolOptions options;
  options.games = trace.games;
  options.env_count = trace.env_count;
  options.environment = trace.options;
  return options;
}

absl::StatusOr<std::unique_ptr<Player>> MakeLocalPlayer(const Trace& trace, int32_t worker_count,
                                                        bool with_pictures,
                                                        std::shared_ptr<const SharedArt> art) {
  PoolOptions options = PoolOptionsOf(trace);
  options.art = std::move(art);
  // The calling thread is a worker too.
  auto pool = Pool::Create(options, std::make_shared<WorkerPool>(worker_count - 1));
  if (!pool.ok()) {
    return pool.status();
  }
  return std::make_unique<LocalPlayer>(*std::move(pool), with_pictures);
}

}  // namespace procgen
