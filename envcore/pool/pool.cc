#include "envcore/pool/pool.h"

#include <algorithm>
#include <utility>

#include "absl/functional/function_ref.h"
#include "absl/strings/str_cat.h"
#include "envcore/pool/frame_stack.h"
#include "envcore/pool/pool_input.h"
#include "envcore/pool/spin_wait.h"
#include "envcore/render/scene/rasteriser.h"

namespace procgen {
namespace {

// Batches with fewer observation bytes than this are not prefetched: each worker's part is still in
// its cache from the last step.
constexpr size_t kCachedBytesMax = 2 << 20;
constexpr size_t kCacheLineBytes = 64;
// Largest repeat for which a single environment is stepped on the calling thread.
constexpr int32_t kRepeatHereMax = 4;

// Prefetches memory that will be written soon, so that the writes do not wait for it.
void FetchForWriting(absl::Span<uint8_t> memory) {
  for (size_t i = 0; i < memory.size(); i += kCacheLineBytes) {
    __builtin_prefetch(memory.data() + i, 1);
  }
}

}  // namespace

// Buffers of one worker.
struct Pool::WorkerScratch {
  Scene scene;
  Rasteriser rasteriser;
};

// Steps a slice: one item per environment.
class Pool::StepJob final : public ParallelJob {
 public:
  explicit StepJob(Pool* pool) : pool_(pool) {}

  void Set(const StepInput& input, const Batch& batch, DoneCallback done) {
    input_ = input;
    batch_ = batch;
    done_ = std::move(done);
    fetches_ahead_ = batch.observations.size() > kCachedBytesMax;
  }

 protected:
  void RunItem(int32_t item, int32_t worker) override {
    const auto row = static_cast<size_t>(item);
    const size_t index = static_cast<size_t>(input_.first) + row;
    const View view = {*pool_->environments_[index], index, row,
                       *pool_->worker_scratch_[static_cast<size_t>(worker)]};
    if (pool_->frame_stacks_.empty()) {
      Run(view);
    } else {
      RunStacked(view, pool_->frame_stacks_[index]);
    }
    Write(view.environment.result(), row);
  }

  void OnDone() override {
    DoneCallback done = std::move(done_);
    pool_->Release();
    done(OkStatus());
  }

 private:
  // An environment, its index in the pool, its row in the batch and the worker's buffers.
  struct View {
    Environment& environment;
    size_t index;
    size_t row;
    WorkerScratch& scratch;
  };

  // Without a stack, an observation is the current frame.
  void Run(const View& view) {
    if (fetches_ahead_) {
      FetchForWriting(RowOf(batch_.observations, view.row));
    }
    Move(view, [&] {
      if (!batch_.final_observations.empty()) {
        Draw(view, RowOf(batch_.final_observations, view.row));
      }
    });
    if (!batch_.observations.empty()) {
      Draw(view, RowOf(batch_.observations, view.row));
    }
  }

  // With a stack, every step is drawn, even when no observations are requested: a stack must not
  // depend on which observations were requested before.
  void RunStacked(const View& view, FrameStack& stack) {
    if (stack.empty()) {
      Draw(view, stack.Next());
    }
    bool ended = false;
    const bool moved = Move(view, [&] {
      if (!batch_.final_observations.empty()) {
        Draw(view, stack.Next());
        stack.CopyTo(RowOf(batch_.final_observations, view.row));
        ended = true;
      }
    });
    const bool begins = moved && view.environment.result().first;
    if (begins) {
      stack.Clear();
    }
    // If an episode has ended and the next has not begun, the last frame is in the stack already.
    if (begins || (moved && !ended)) {
      Draw(view, stack.Next());
    }
    if (!batch_.observations.empty()) {
      stack.CopyTo(RowOf(batch_.observations, view.row));
    }
  }

  // Resets or steps the environment as the input says. Returns whether it did either.
  bool Move(const View& view, absl::FunctionRef<void()> before_new_level) {
    if (const Reset* reset = std::exchange(pool_->resets_[view.index], nullptr)) {
      view.environment.Reset(reset->level_seed, reset->rand_seed);
      return true;
    }
    if (input_.steps) {
      view.environment.Step(input_.actions[view.row], input_.repeat, [&] {
        CaptureFinalScene(view);
        before_new_level();
      });
    }
    return input_.steps;
  }

  // Captures the scene if the batch asks for it.
  void CaptureFinalScene(const View& view) const {
    const auto number = static_cast<int32_t>(view.index);
    auto* const wanted = std::lower_bound(
        batch_.final_scenes.begin(), batch_.final_scenes.end(), number,
        [](const FinalScene& each, int32_t environment) { return each.environment < environment; });
    if (wanted != batch_.final_scenes.end() && wanted->environment == number) {
      wanted->scene =
          std::make_shared<const SceneSnapshot>(view.environment, pool_->ArtOf(view.index));
    }
  }

  absl::Span<uint8_t> RowOf(absl::Span<uint8_t> observations, size_t row) const {
    const size_t bytes = pool_->observation_bytes();
    return observations.subspan(row * bytes, bytes);
  }

  void Draw(const View& view, absl::Span<uint8_t> frame) const {
    view.environment.FillScene(&view.scratch.scene);
    view.scratch.rasteriser.DrawAgentView(view.scratch.scene, *pool_->ArtOf(view.index),
                                          &pool_->static_layers_[view.index],
                                          pool_->options_.observation_format.frame, frame);
  }

  void Write(const StepResult& result, size_t row) const {
#define PROCGEN_WRITE(type, name, member)                \
  if (!batch_.name.empty()) {                            \
    batch_.name[row] = static_cast<type>(result.member); \
  }
    PROCGEN_BATCH_NUMBERS(PROCGEN_WRITE)
#undef PROCGEN_WRITE
  }

  Pool* const pool_;
  StepInput input_;
  Batch batch_;
  DoneCallback done_;
  bool fetches_ahead_ = false;  // prefetch each row while its environment is stepped
};

StatusOr<std::unique_ptr<Pool>> Pool::Create(const PoolOptions& options,
                                             std::shared_ptr<WorkerPool> workers) {
  if (Status status = CheckPoolOptions(options); !status.ok()) {
    return status;
  }
  std::vector<EnvironmentOptions> resolved;
  for (const std::string& game : options.games) {
    auto environment_options = ResolveOptions(game, options.environment);
    if (!environment_options.ok()) {
      return environment_options.status();
    }
    resolved.push_back(*environment_options);
  }
  std::unique_ptr<Pool> pool(new Pool(options, std::move(workers)));
  // The level-seed stream of environment n depends only on rand_seed and n.
  RandomStream stream_seeds(options.environment.rand_seed);
  for (int32_t i = 0; i < options.first_env; ++i) {
    stream_seeds.Raw();
  }
  const std::shared_ptr<const SharedArt> art =
      options.art == nullptr ? SharedArt::Embedded() : options.art;
  const size_t game_count = options.games.size();
  for (int32_t i = 0; i < options.env_count; ++i) {
    const int32_t number = options.first_env + i;
    const size_t game_index = static_cast<size_t>(number) % game_count;
    const uint32_t drawn_seed = stream_seeds.Raw();
    const LevelSampler* sampler = options.level_sampler.get();
    pool->environments_.push_back(std::make_unique<Environment>(
        *FindGame(options.games[game_index]), resolved[game_index],
        sampler == nullptr ? drawn_seed : sampler->StreamSeedOf(number), options.autoreset_mode,
        options.level_sampler));
    if (pool->art_[game_index] == nullptr) {
      pool->art_[game_index] =
          art->Of(*FindGame(options.games[game_index]), pool->environments_.back()->game().art());
    }
  }
  return pool;
}

Pool::Pool(const PoolOptions& options, std::shared_ptr<WorkerPool> workers)
    : options_(options),
      workers_(std::move(workers)),
      level_sampler_(options.level_sampler),
      art_(options.games.size()),
      static_layers_(static_cast<size_t>(options.env_count)),
      resets_(static_cast<size_t>(options.env_count)),
      job_(std::make_unique<StepJob>(this)) {
  environments_.reserve(static_cast<size_t>(options.env_count));
  if (const ObservationFormat& format = options.observation_format; format.frame_stack > 1) {
    frame_stacks_.assign(static_cast<size_t>(options.env_count),
                         FrameStack(format.frame.bytes(), format.frame_stack));
  }
  for (int32_t worker = 0; worker < workers_->worker_count(); ++worker) {
    worker_scratch_.push_back(std::make_unique<WorkerScratch>());
  }
}

Pool::~Pool() = default;

const std::shared_ptr<const GameArt>& Pool::ArtOf(size_t index) const {
  return art_[(static_cast<size_t>(options_.first_env) + index) % art_.size()];
}

Status Pool::CheckNoneAwaitsReset(const StepInput& input) const {
  if (!input.steps || options_.autoreset_mode != AutoresetMode::kDisabled) {
    return OkStatus();
  }
  for (int32_t i = input.first; i < input.first + input.count; ++i) {
    const bool is_reset = std::any_of(input.resets.begin(), input.resets.end(),
                                      [i](const Reset& reset) { return reset.environment == i; });
    if (AwaitsReset(i) && !is_reset) {
      return FailedPreconditionError(absl::StrCat("the episode of environment ", i,
                                                  " has ended: reset it before it is stepped"));
    }
  }
  return OkStatus();
}

void Pool::ApplySparse(const StepInput& input) {
  for (const NextLevel& next : input.next_levels) {
    environments_[static_cast<size_t>(next.environment)]->SetNextLevel(next.level_seed);
  }
  for (const Reset& reset : input.resets) {
    resets_[static_cast<size_t>(reset.environment)] = &reset;
  }
}

Status Pool::Begin(const StepInput& input, const Batch& batch) {
  if (Status status = CheckStep(input, batch, env_count(), observation_bytes()); !status.ok()) {
    return status;
  }
  if (!Take()) {
    return AbortedError("another call steps or reads this pool; retry when it has returned");
  }
  if (Status status = CheckNoneAwaitsReset(input); !status.ok()) {
    Release();
    return status;
  }
  ApplySparse(input);
  return OkStatus();
}

Status Pool::Step(const StepInput& input, const Batch& batch) {
  if (Status status = Begin(input, batch); !status.ok()) {
    return status;
  }
  CompletionEvent done;
  job_->Set(input, batch, [&done](const Status& /*status*/) { done.Set(); });
  workers_->SubmitAndParticipate(*job_, input.count);
  done.Wait();
  return OkStatus();
}

void Pool::StepAsync(const StepInput& input, const Batch& batch, DoneCallback done) {
  if (Status status = Begin(input, batch); !status.ok()) {
    done(status);
    return;
  }
  job_->Set(input, batch, std::move(done));
  if (input.count == 1 && input.repeat <= kRepeatHereMax) {
    workers_->SubmitAndParticipate(*job_, input.count);
  } else {
    workers_->Submit(*job_, input.count);
  }
}

Status Pool::Observe(int32_t first, int32_t count, const Batch& batch) {
  return Step({.first = first, .count = count, .steps = false}, batch);
}

Status Pool::SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler) {
  if (!Take()) {
    return AbortedError("another call steps or reads this pool; retry when it has returned");
  }
  level_sampler_ = std::move(level_sampler);
  int32_t number = options_.first_env;
  for (const std::unique_ptr<Environment>& environment : environments_) {
    environment->SetLevelSampler(level_sampler_);
    environment->SeedLevels(level_sampler_->StreamSeedOf(number));
    ++number;
  }
  Release();
  return OkStatus();
}

Status Pool::Render(int32_t environment, int32_t size_px, absl::Span<uint8_t> frame,
                    bool whole_level) {
  if (Status status = CheckIndex(environment); !status.ok()) {
    return status;
  }
  if (size_px < kHumanViewSizePxMin || size_px > kHumanViewSizePxMax) {
    return InvalidArgumentError(absl::StrCat("size_px is ", size_px, ", must be in [",
                                             kHumanViewSizePxMin, ", ", kHumanViewSizePxMax, "]"));
  }
  const size_t bytes = static_cast<size_t>(size_px) * static_cast<size_t>(size_px) * 3;
  if (frame.size() != bytes) {
    return InvalidArgumentError(
        absl::StrCat("frame has ", frame.size(), " bytes, must have ", bytes));
  }
  if (!Take()) {
    return AbortedError("another call steps or reads this pool; retry when it has returned");
  }
  WorkerScratch& scratch = *worker_scratch_.back();
  const auto index = static_cast<size_t>(environment);
  if (whole_level) {
    environments_[index]->FillLevelScene(&scratch.scene);
  } else {
    environments_[index]->FillScene(&scratch.scene);
  }
  scratch.rasteriser.DrawHumanView(scratch.scene, *ArtOf(index), size_px, frame);
  Release();
  return OkStatus();
}

StatusOr<SceneSnapshot> Pool::CaptureScene(int32_t environment, bool whole_level) {
  if (Status status = CheckIndex(environment); !status.ok()) {
    return status;
  }
  if (!Take()) {
    return AbortedError("another call steps or reads this pool; retry when it has returned");
  }
  const auto index = static_cast<size_t>(environment);
  SceneSnapshot snapshot = whole_level
                               ? SceneSnapshot::OfLevel(environments_[index].get(), ArtOf(index))
                               : SceneSnapshot(*environments_[index], ArtOf(index));
  Release();
  return snapshot;
}

StatusOr<AgentPosition> Pool::FindAgent(int32_t environment) {
  if (Status status = CheckIndex(environment); !status.ok()) {
    return status;
  }
  if (!Take()) {
    return AbortedError("another call steps or reads this pool; retry when it has returned");
  }
  const World& world = environments_[static_cast<size_t>(environment)]->game().world();
  const auto width = static_cast<float>(world.grid.width());
  const auto height = static_cast<float>(world.grid.height());
  const float cells = std::max(width, height);
  const AgentPosition position = {0.5F + (world.agent().x - width / 2) / cells,
                                  0.5F - (world.agent().y - height / 2) / cells};
  Release();
  return position;
}

}  // namespace procgen
