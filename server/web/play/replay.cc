#include "server/web/play/replay.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/types/span.h"
#include "envcore/games/game_catalog.h"
#include "envcore/pool/pool.h"
#include "server/web/play/play.h"
#include "server/wire/convert_pool.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

// Maximum number of snapshots of a replay (1 to 12 kB each), and minimum distance in rows.
constexpr int32_t kSnapshotCountMax = 256;
constexpr int32_t kSnapshotRowsMin = 64;

// The values of one environment in a trace.
template <typename T>
std::vector<T> ColumnOf(const std::vector<T>& values, const Trace& trace, int32_t environment) {
  std::vector<T> column;
  const auto row = static_cast<size_t>(trace.env_count);
  column.reserve(values.size() / row);
  for (auto i = static_cast<size_t>(environment); i < values.size(); i += row) {
    column.push_back(values[i]);
  }
  return column;
}

// The recorded rows of one environment.
Trace EnvironmentOf(const Trace& trace, int32_t environment) {
  Trace one;
  one.games = trace.games;
  one.options = trace.options;
  one.env_count = 1;
  one.step_count = trace.step_count;
  one.actions = ColumnOf(trace.actions, trace, environment);
  one.rewards = ColumnOf(trace.rewards, trace, environment);
  one.first = ColumnOf(trace.first, trace, environment);
  one.level_seeds = ColumnOf(trace.level_seeds, trace, environment);
  one.prev_level_seeds = ColumnOf(trace.prev_level_seeds, trace, environment);
  one.prev_level_complete = ColumnOf(trace.prev_level_complete, trace, environment);
  if (!trace.fingerprints.empty()) {
    one.fingerprints = {trace.fingerprints[static_cast<size_t>(environment)]};
  }
  return one;
}

// The spec of a pool for one environment of a trace. It is a slice of the whole, so it behaves the
// same.
v1::PoolSpec SpecOf(const ReplaySource& source) {
  PoolOptions options;
  options.games = source.trace.games;
  options.env_count = 1;
  options.environment = source.trace.options;
  options.first_env = source.environment;
  options.total_env_count = source.trace.env_count;
  return PoolSpecMessageOf(options);
}

absl::Status CheckSource(const ReplaySource& source) {
  const Trace& trace = source.trace;
  if (trace.step_count >= Replay::kRowsMax) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the trace has ", trace.step_count, " steps, allowed: at most ", Replay::kRowsMax - 1));
  }
  if (source.environment < 0 || source.environment >= trace.env_count) {
    return absl::InvalidArgumentError(
        absl::StrCat("environment is ", source.environment, ", the trace has ", trace.env_count));
  }
  for (const int32_t action : trace.actions) {
    if (action < kEndEpisodeAction || action >= kActionCount) {
      return absl::InvalidArgumentError(
          absl::StrCat("the trace has action ", action, ", allowed: -1 to ", kActionCount - 1));
    }
  }
  return absl::OkStatus();
}

// The first row at which two lists differ bitwise, or their length.
template <typename T>
size_t FirstDifference(const std::vector<T>& expected, const std::vector<T>& got) {
  const size_t size = std::min(expected.size(), got.size());
  for (size_t i = 0; i < size; ++i) {
    // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): 0 and -0 are to differ
    if (std::memcmp(&expected[i], &got[i], sizeof(T)) != 0) {
      return i;
    }
  }
  return size;
}

// Finds the first difference over all columns.
class Comparison {  // NOLINT(bugprone-exception-escape): what is moved throws nothing
 public:
  template <typename T>
  void Compare(const char* field, const std::vector<T>& expected, const std::vector<T>& got) {
    const size_t row = FirstDifference(expected, got);
    if (row < expected.size() && row < got.size() && row < row_) {
      row_ = row;
      difference_ = {
          {"row", row}, {"field", field}, {"expected", expected[row]}, {"got", got[row]}};
    }
  }

  // Null if there is no difference.
  Json difference() const { return difference_; }

 private:
  size_t row_ = SIZE_MAX;
  Json difference_ = nullptr;
};

Json DifferenceOf(const Trace& expected, const Recording& recording) {
  const Trace& got = recording.trace();
  Comparison comparison;
  comparison.Compare("reward", expected.rewards, got.rewards);
  comparison.Compare("first", expected.first, got.first);
  comparison.Compare("level_seed", expected.level_seeds, got.level_seeds);
  comparison.Compare("prev_level_seed", expected.prev_level_seeds, got.prev_level_seeds);
  comparison.Compare("prev_level_complete", expected.prev_level_complete, got.prev_level_complete);
  Json difference = comparison.difference();
  if (difference.is_null() && !expected.fingerprints.empty() &&
      expected.fingerprints != got.fingerprints) {
    difference = {{"row", recording.row_count() - 1},
                  {"field", "fingerprint"},
                  {"expected", expected.fingerprints.front().empty()
                                   ? Json()
                                   : FingerprintJson(expected.fingerprints.front().back())},
                  {"got", FingerprintJson(recording.FingerprintAt(recording.row_count() - 1))}};
  }
  return difference;
}

Json HeaderOf(const ReplaySource& source, const Recording& recording) {
  const EnvironmentOptions& options = source.trace.options;
  return {{"games", source.trace.games},
          {"mode", std::string(DistributionModeName(options.distribution_mode))},
          {"level_seed", recording.trace().level_seeds.front()},
          {"env_count", source.trace.env_count},
          {"environment", source.environment},
          {"options",
           {{"num_levels", options.num_levels},
            {"start_level", options.start_level},
            {"rand_seed", options.rand_seed},
            {"use_sequential_levels", options.use_sequential_levels},
            {"center_agent", options.center_agent},
            {"use_backgrounds", options.use_backgrounds},
            {"use_generated_assets", options.use_generated_assets},
            {"use_monochrome_assets", options.use_monochrome_assets},
            {"restrict_themes", options.restrict_themes},
            {"paint_vel_info", options.paint_vel_info},
            {"debug_mode", options.debug_mode}}}};
}

}  // namespace

absl::StatusOr<std::unique_ptr<Replay>> Replay::Open(std::shared_ptr<procgen_client::Client> client,
                                                     const ReplaySource& source,
                                                     int32_t human_size_px,
                                                     const std::atomic<bool>& is_stopping) {
  if (absl::Status status = CheckSource(source); !status.ok()) {
    return status;
  }
  absl::StatusOr<std::unique_ptr<SingleEnvPool>> pool =
      SingleEnvPool::Make(std::move(client), "replay", SpecOf(source));
  if (!pool.ok()) {
    return pool.status();
  }
  const Trace expected = EnvironmentOf(source.trace, source.environment);
  const int32_t snapshot_rows =
      std::max(kSnapshotRowsMin, expected.step_count / kSnapshotCountMax + 1);
  std::unique_ptr<Replay> replay(new Replay(
      *std::move(pool), Recording(expected.games, expected.options), human_size_px, snapshot_rows));
  if (absl::Status status = replay->PlayAll(expected, is_stopping); !status.ok()) {
    return status;
  }
  replay->facts_ = replay->recording_.Summary();
  replay->facts_["header"] = HeaderOf(source, replay->recording_);
  replay->facts_["file_name"] = replay->recording_.FileFacts()["file_name"];
  replay->facts_["difference"] = DifferenceOf(expected, replay->recording_);
  return replay;
}

Replay::Replay(std::unique_ptr<SingleEnvPool> pool, Recording recording, int32_t human_size_px,
               int32_t snapshot_rows)
    : pool_(std::move(pool)),
      human_size_px_(human_size_px),
      snapshot_rows_(snapshot_rows),
      recording_(std::move(recording)) {}

absl::Status Replay::TakeSnapshot(int32_t row) {
  absl::StatusOr<v1::State> state = pool_->Save();
  if (!state.ok()) {
    return state.status();
  }
  snapshots_[row] = *std::move(state);
  return absl::OkStatus();
}

absl::Status Replay::PlayAll(const Trace& trace, const std::atomic<bool>& is_stopping) {
  const absl::StatusOr<Row> start = pool_->Observe();
  if (!start.ok()) {
    return start.status();
  }
  recording_.Begin(*start);
  const absl::Span<const int32_t> actions = trace.actions;
  while (true) {
    if (absl::Status status = TakeSnapshot(row_); !status.ok()) {
      return status;
    }
    if (row_ == trace.step_count) {
      return absl::OkStatus();
    }
    if (is_stopping) {
      return absl::CancelledError("the page disconnected");
    }
    const auto begin = static_cast<size_t>(row_);
    const auto part = actions.subspan(begin, static_cast<size_t>(snapshot_rows_));
    std::vector<Row> rows;
    const auto add = [&rows](const Row& row) { rows.push_back(row); };
    absl::StatusOr<bool> is_as_recorded = pool_->StepAll(
        part, [&](size_t action) { return trace.first[begin + action + 1] != 0; }, add);
    if (is_as_recorded.ok() && !*is_as_recorded) {
      // An episode ends earlier than recorded: once more, without pipelining.
      rows.clear();
      if (absl::Status status = pool_->Restore(snapshots_[row_]); !status.ok()) {
        return status;
      }
      is_as_recorded = pool_->StepAll(
          part, [](size_t) { return true; }, add);
    }
    if (!is_as_recorded.ok()) {
      return is_as_recorded.status();
    }
    for (size_t i = 0; i < part.size(); ++i) {
      recording_.Add(part[i], rows[i]);
    }
    row_ += static_cast<int32_t>(part.size());
  }
}

absl::StatusOr<Row> Replay::GoTo(int32_t row) {
  if (row < 0 || row >= row_count()) {
    return absl::InvalidArgumentError(
        absl::StrCat("row is ", row, ", the replay has rows 0 to ", row_count() - 1));
  }
  const std::vector<uint8_t>& first = recording_.trace().first;
  // The last frames of an episode are drawn by the step that ends it.
  const int32_t from = row > 0 && first[static_cast<size_t>(row)] != 0 ? row - 1 : row;
  const auto nearest = std::prev(snapshots_.upper_bound(from));
  if (from < row_ || nearest->first > row_) {
    if (absl::Status status = pool_->Restore(nearest->second); !status.ok()) {
      return status;
    }
    row_ = nearest->first;
  }
  if (row == row_) {
    return pool_->Observe();
  }
  const absl::Span<const int32_t> actions = recording_.trace().actions;
  // All steps but the last, whose image is needed.
  const auto begin = static_cast<size_t>(row_);
  const auto before = actions.subspan(begin, static_cast<size_t>(row - row_ - 1));
  const absl::StatusOr<bool> is_as_before = pool_->StepAll(
      before, [&](size_t action) { return first[begin + action + 1] != 0; }, [](const Row&) {});
  if (!is_as_before.ok()) {
    return is_as_before.status();
  }
  if (!*is_as_before) {
    return absl::InternalError("the same actions gave another episode end than before");
  }
  row_ = row;
  return pool_->Step(actions[static_cast<size_t>(row - 1)], human_size_px_);
}

absl::StatusOr<Branch> Replay::BranchAt(int32_t row) {
  absl::StatusOr<Row> at = GoTo(row);
  if (!at.ok()) {
    return at.status();
  }
  absl::StatusOr<v1::State> state = pool_->Save();
  if (!state.ok()) {
    return state.status();
  }
  Recording recording = recording_;
  recording.Truncate(row + 1);
  return Branch{pool_->spec(), *std::move(state), std::move(recording), *std::move(at)};
}

absl::StatusOr<Answer> Replay::Seek(int32_t row, int32_t map_size_px) {
  absl::StatusOr<Row> shown = GoTo(row);
  if (!shown.ok()) {
    return shown.status();
  }
  absl::StatusOr<Answer> answer =
      ViewAnswer(recording_.ViewOf(row), *std::move(shown), pool_.get(), human_size_px_);
  if (answer.ok() && map_size_px > 0) {
    if (absl::Status status = AddMap(row, map_size_px, &*answer); !status.ok()) {
      return status;
    }
  }
  return answer;
}

absl::Status Replay::AddMap(int32_t row, int32_t map_size_px, Answer* answer) {
  const int32_t first_row = FirstRowOfLevel(recording_.trace(), row);
  if (!path_.has_value() || path_->first_row != first_row) {
    const auto nearest = std::prev(snapshots_.upper_bound(first_row));
    const v1::PoolSpec& spec = pool_->spec();
    const std::string& game = spec.games(spec.first_env() % spec.games_size());
    absl::StatusOr<AgentPath> path = FollowAgent(
        game, recording_.trace(), nearest->second.snapshot(), nearest->first, first_row);
    if (!path.ok()) {
      return path.status();
    }
    path_ = *std::move(path);
  }
  absl::StatusOr<std::string> map = pool_->Draw(map_size_px, v1::FRAME_VIEW_LEVEL);
  if (!map.ok()) {
    return map.status();
  }
  answer->result["path"] = {{"first_row", first_row}, {"x", path_->x}, {"y", path_->y}};
  answer->parts.push_back(
      {"map", "png", *std::move(map), {{"width", map_size_px}, {"height", map_size_px}}});
  return absl::OkStatus();
}

}  // namespace procgen::web
