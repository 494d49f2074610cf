#include "envcore/pool/pool.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/notification.h"
#include "envcore/render/rasteriser.h"

namespace procgen {
namespace {

absl::Status CheckSpan(absl::string_view name, size_t size, size_t rows, size_t values_per_row) {
  if (size != 0 && size != rows * values_per_row) {
    return absl::InvalidArgumentError(absl::StrCat("the batch's ", name, " have ", size,
                                                   " values, must have ", rows * values_per_row,
                                                   " or none"));
  }
  return absl::OkStatus();
}

absl::Status CheckBatch(const Batch& batch, size_t rows) {
  for (const absl::Status& status :
       {CheckSpan("observations", batch.observations.size(), rows, kObservationBytes),
        CheckSpan("rewards", batch.rewards.size(), rows, 1),
        CheckSpan("first", batch.first.size(), rows, 1),
        CheckSpan("terminated", batch.terminated.size(), rows, 1),
        CheckSpan("truncated", batch.truncated.size(), rows, 1),
        CheckSpan("level_seeds", batch.level_seeds.size(), rows, 1),
        CheckSpan("prev_level_seeds", batch.prev_level_seeds.size(), rows, 1),
        CheckSpan("prev_level_complete", batch.prev_level_complete.size(), rows, 1),
        CheckSpan("episode_returns", batch.episode_returns.size(), rows, 1),
        CheckSpan("episode_lengths", batch.episode_lengths.size(), rows, 1),
        CheckSpan("fingerprints", batch.fingerprints.size(), rows, 1),
        CheckSpan("final_observations", batch.final_observations.size(), rows,
                  kObservationBytes)}) {
    if (!status.ok()) {
      return status;
    }
  }
  return absl::OkStatus();
}

absl::Status CheckActions(const StepInput& input) {
  const size_t expected = input.steps ? static_cast<size_t>(input.count) : 0;
  if (input.actions.size() != expected) {
    return absl::InvalidArgumentError(absl::StrCat("actions has ", input.actions.size(),
                                                   " entries, the slice has ", expected,
                                                   " environments to step"));
  }
  for (size_t i = 0; i < input.actions.size(); ++i) {
    if (input.actions[i] < kEndEpisodeAction || input.actions[i] >= kActionCount) {
      return absl::InvalidArgumentError(absl::StrCat(
          "action ", input.actions[i], " of environment ", input.first + static_cast<int32_t>(i),
          " is not in [", kEndEpisodeAction, ", ", kActionCount - 1, "]"));
    }
  }
  if (input.repeat < 1 || input.repeat > kRepeatMax) {
    return absl::InvalidArgumentError(
        absl::StrCat("repeat is ", input.repeat, ", must be in [1, ", kRepeatMax, "]"));
  }
  return absl::OkStatus();
}

// Checks that the entries of a sparse list name environments of the slice, each once.
template <typename Entry>
absl::Status CheckSparse(absl::string_view name, absl::Span<const Entry> entries,
                         const StepInput& input) {
  std::vector<bool> had;
  if (!entries.empty()) {
    had.resize(static_cast<size_t>(input.count));
  }
  for (const Entry& entry : entries) {
    const int64_t row = int64_t{entry.environment} - input.first;
    if (row < 0 || row >= input.count) {
      return absl::InvalidArgumentError(absl::StrCat(name, " names environment ", entry.environment,
                                                     ", the slice is [", input.first, ", ",
                                                     input.first + input.count, ")"));
    }
    if (had[static_cast<size_t>(row)]) {
      return absl::InvalidArgumentError(
          absl::StrCat(name, " names environment ", entry.environment, " twice"));
    }
    had[static_cast<size_t>(row)] = true;
  }
  return absl::OkStatus();
}

absl::Status CheckOptions(const PoolOptions& options) {
  if (options.games.empty()) {
    return absl::InvalidArgumentError("games is empty, must name at least one game");
  }
  if (options.env_count < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("env_count is ", options.env_count, ", must be at least 1"));
  }
  if (options.first_environment < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("first_environment is ", options.first_environment, ", must be at least 0"));
  }
  const int64_t end = int64_t{options.first_environment} + options.env_count;
  const int64_t total = options.total_environments == 0 ? end : options.total_environments;
  if (total < end) {
    return absl::InvalidArgumentError(
        absl::StrCat("total_environments is ", options.total_environments,
                     ", must be at least first_environment + env_count = ", end, ", or 0"));
  }
  if (total > kTotalEnvironmentsMax) {
    return absl::InvalidArgumentError(absl::StrCat("there are ", total,
                                                   " environments in the whole, must be at most ",
                                                   kTotalEnvironmentsMax));
  }
  const auto game_count = static_cast<int64_t>(options.games.size());
  if (total % game_count != 0) {
    return absl::InvalidArgumentError(absl::StrCat("there are ", total, " environments for ",
                                                   game_count, " games, must be a multiple of it"));
  }
  return absl::OkStatus();
}

}  // namespace

// What a worker needs for itself.
struct Pool::Workbench {
  Scene scene;
  Rasteriser rasteriser;
};

// Steps a slice: one item an environment.
class Pool::StepJob final : public CrewJob {
 public:
  explicit StepJob(Pool* pool) : pool_(pool) {}

  void Set(const StepInput& input, const Batch& batch, DoneCallback done) {
    input_ = input;
    batch_ = batch;
    done_ = std::move(done);
  }

 protected:
  void RunItem(int32_t item, int32_t worker) override {
    const auto row = static_cast<size_t>(item);
    const auto index = static_cast<size_t>(input_.first) + row;
    Environment& environment = *pool_->environments_[index];
    Workbench& workbench = *pool_->workbenches_[static_cast<size_t>(worker)];
    if (const Reset* reset = std::exchange(pool_->resets_[index], nullptr)) {
      environment.Reset(reset->level_seed, reset->rand_seed);
    } else if (input_.steps) {
      environment.Step(input_.actions[row], input_.repeat, [&] {
        Draw(environment, index, row, workbench, batch_.final_observations);
      });
    }
    Draw(environment, index, row, workbench, batch_.observations);
    Write(environment.result(), row);
  }

  void OnDone() override {
    DoneCallback done = std::move(done_);
    pool_->Release();
    done(absl::OkStatus());
  }

 private:
  void Draw(const Environment& environment, size_t index, size_t row, Workbench& workbench,
            absl::Span<uint8_t> frames) const {
    if (frames.empty()) {
      return;
    }
    environment.FillScene(&workbench.scene);
    workbench.rasteriser.DrawAgentView(workbench.scene, *pool_->ArtOf(index),
                                       &pool_->still_layers_[index],
                                       frames.subspan(row * kObservationBytes, kObservationBytes));
  }

  void Write(const StepResult& result, size_t row) const {
    const auto write = [row](auto span, auto value) {
      if (!span.empty()) {
        span[row] = value;
      }
    };
    write(batch_.rewards, result.reward);
    write(batch_.first, static_cast<uint8_t>(result.first));
    write(batch_.terminated, static_cast<uint8_t>(result.terminated));
    write(batch_.truncated, static_cast<uint8_t>(result.truncated));
    write(batch_.level_seeds, result.level_seed);
    write(batch_.prev_level_seeds, result.prev_level_seed);
    write(batch_.prev_level_complete, static_cast<uint8_t>(result.prev_level_complete));
    write(batch_.episode_returns, result.episode_return);
    write(batch_.episode_lengths, result.episode_length);
    write(batch_.fingerprints, result.fingerprint);
  }

  Pool* const pool_;
  StepInput input_;
  Batch batch_;
  DoneCallback done_;
};

absl::StatusOr<std::unique_ptr<Pool>> Pool::Create(const PoolOptions& options,
                                                   std::shared_ptr<Crew> crew) {
  if (absl::Status status = CheckOptions(options); !status.ok()) {
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
  std::unique_ptr<Pool> pool(new Pool(options, std::move(crew)));
  // Environment n's choice of levels depends on rand_seed and n only.
  RandomStream stream_seeds(options.environment.rand_seed);
  for (int32_t i = 0; i < options.first_environment; ++i) {
    stream_seeds.Raw();
  }
  const std::shared_ptr<const SharedArt> art =
      options.art == nullptr ? SharedArt::Embedded() : options.art;
  const size_t game_count = options.games.size();
  for (int32_t i = 0; i < options.env_count; ++i) {
    const size_t game_index = static_cast<size_t>(options.first_environment + i) % game_count;
    pool->environments_.push_back(
        std::make_unique<Environment>(*FindGame(options.games[game_index]), resolved[game_index],
                                      stream_seeds.Raw(), options.episode_end));
    if (pool->art_[game_index] == nullptr) {
      pool->art_[game_index] =
          art->Of(*FindGame(options.games[game_index]), pool->environments_.back()->game().art());
    }
  }
  return pool;
}

Pool::Pool(const PoolOptions& options, std::shared_ptr<Crew> crew)
    : options_(options),
      crew_(std::move(crew)),
      art_(options.games.size()),
      still_layers_(static_cast<size_t>(options.env_count)),
      resets_(static_cast<size_t>(options.env_count)),
      job_(std::make_unique<StepJob>(this)) {
  environments_.reserve(static_cast<size_t>(options.env_count));
  for (int32_t worker = 0; worker < crew_->worker_count(); ++worker) {
    workbenches_.push_back(std::make_unique<Workbench>());
  }
}

Pool::~Pool() = default;

const GameArt* Pool::ArtOf(size_t index) const {
  return art_[(static_cast<size_t>(options_.first_environment) + index) % art_.size()].get();
}

absl::Status Pool::Check(const StepInput& input, const Batch& batch) const {
  if (input.first < 0 || input.count < 1 || int64_t{input.first} + input.count > env_count()) {
    return absl::InvalidArgumentError(absl::StrCat("the slice is ", input.count,
                                                   " environments from ", input.first,
                                                   ", the pool has ", env_count()));
  }
  for (const absl::Status& status :
       {CheckActions(input), CheckSparse("next_levels", input.next_levels, input),
        CheckSparse("resets", input.resets, input),
        CheckBatch(batch, static_cast<size_t>(input.count))}) {
    if (!status.ok()) {
      return status;
    }
  }
  return absl::OkStatus();
}

absl::Status Pool::CheckNoneAwaitsReset(const StepInput& input) const {
  if (!input.steps || options_.episode_end != EpisodeEnd::kDisabled) {
    return absl::OkStatus();
  }
  for (int32_t i = input.first; i < input.first + input.count; ++i) {
    const bool is_reset = std::any_of(input.resets.begin(), input.resets.end(),
                                      [i](const Reset& reset) { return reset.environment == i; });
    if (AwaitsReset(i) && !is_reset) {
      return absl::FailedPreconditionError(absl::StrCat(
          "the episode of environment ", i, " has ended: reset it before it is stepped"));
    }
  }
  return absl::OkStatus();
}

void Pool::ApplySparse(const StepInput& input) {
  for (const NextLevel& next : input.next_levels) {
    environments_[static_cast<size_t>(next.environment)]->SetNextLevel(next.level_seed);
  }
  for (const Reset& reset : input.resets) {
    resets_[static_cast<size_t>(reset.environment)] = &reset;
  }
}

absl::Status Pool::Begin(const StepInput& input, const Batch& batch) {
  if (absl::Status status = Check(input, batch); !status.ok()) {
    return status;
  }
  if (!Take()) {
    return absl::AbortedError("another call steps or reads this pool; repeat when it is done");
  }
  if (absl::Status status = CheckNoneAwaitsReset(input); !status.ok()) {
    Release();
    return status;
  }
  ApplySparse(input);
  return absl::OkStatus();
}

absl::Status Pool::Step(const StepInput& input, const Batch& batch) {
  if (absl::Status status = Begin(input, batch); !status.ok()) {
    return status;
  }
  absl::Notification done;
  job_->Set(input, batch, [&done](const absl::Status& /*status*/) { done.Notify(); });
  crew_->SubmitAndHelp(*job_, input.count);
  done.WaitForNotification();
  return absl::OkStatus();
}

void Pool::StepAsync(const StepInput& input, const Batch& batch, DoneCallback done) {
  if (absl::Status status = Begin(input, batch); !status.ok()) {
    done(status);
    return;
  }
  job_->Set(input, batch, std::move(done));
  crew_->Submit(*job_, input.count);
}

absl::Status Pool::Observe(int32_t first, int32_t count, const Batch& batch) {
  return Step({.first = first, .count = count, .steps = false}, batch);
}

absl::Status Pool::Render(int32_t environment, int32_t side_px, absl::Span<uint8_t> frame) {
  if (environment < 0 || environment >= env_count()) {
    return absl::InvalidArgumentError(
        absl::StrCat("environment ", environment, " is not in [0, ", env_count(), ")"));
  }
  if (side_px < kHumanViewSidePxMin || side_px > kHumanViewSidePxMax) {
    return absl::InvalidArgumentError(absl::StrCat("side_px is ", side_px, ", must be in [",
                                                   kHumanViewSidePxMin, ", ", kHumanViewSidePxMax,
                                                   "]"));
  }
  const size_t bytes = static_cast<size_t>(side_px) * static_cast<size_t>(side_px) * 3;
  if (frame.size() != bytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("frame has ", frame.size(), " bytes, must have ", bytes));
  }
  if (!Take()) {
    return absl::AbortedError("another call steps or reads this pool; repeat when it is done");
  }
  Workbench& workbench = *workbenches_.back();
  const auto index = static_cast<size_t>(environment);
  environments_[index]->FillScene(&workbench.scene);
  workbench.rasteriser.DrawHumanView(workbench.scene, *ArtOf(index), side_px, frame);
  Release();
  return absl::OkStatus();
}

}  // namespace procgen
