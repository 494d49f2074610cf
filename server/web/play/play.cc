#include "server/web/play/play.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/pool/pool.h"
#include "server/wire/convert_pool.h"

namespace procgen::web {
namespace {

namespace v1 = procgen::v1;

// An empty recording for a pool.
absl::StatusOr<Recording> RecordingOf(const SingleEnvPool& pool) {
  const absl::StatusOr<PoolOptions> options = PoolOptionsOf(pool.spec());
  if (!options.ok()) {
    return options.status();
  }
  return Recording(options->games, options->environment);
}

// The level at the row of a branch.
LevelChoice LevelOf(const Branch& branch) {
  LevelChoice level;
  level.game = branch.spec.games(branch.spec.first_env() % branch.spec.games_size());
  level.options = branch.spec.options();
  level.level_seed = branch.row.level_seed;
  level.has_one_level = level.options.distribution_mode() == v1::DISTRIBUTION_MODE_EXPLORATION;
  return level;
}

}  // namespace

int32_t ReadHumanSize(RequestParams* params) {
  const int32_t size_px =
      params->Integer32Or("human_size_px", kHumanSizePxDefault, 0, kHumanSizePxMax);
  if (size_px != 0 && size_px < kHumanSizePxMin) {
    params->Refuse(absl::StrCat("human_size_px is ", size_px, ", allowed: 0, or integers from ",
                                kHumanSizePxMin, " to ", kHumanSizePxMax));
  }
  return size_px;
}

absl::StatusOr<Answer> ViewAnswer(Json view, Row row, SingleEnvPool* pool, int32_t human_size_px) {
  Answer answer{std::move(view), {}};
  const auto size = [](int32_t size_px) { return Json{{"width", size_px}, {"height", size_px}}; };
  answer.parts.push_back({"agent", "rgb", std::move(row.picture), size(kObservationSizePx)});
  if (!row.final_picture.empty()) {
    answer.parts.push_back(
        {"final_agent", "rgb", std::move(row.final_picture), size(kObservationSizePx)});
  }
  if (!row.final_human.empty()) {
    answer.parts.push_back({"final_human", "png", std::move(row.final_human), size(human_size_px)});
  }
  if (human_size_px > 0) {
    absl::StatusOr<std::string> human = pool->Draw(human_size_px);
    if (!human.ok()) {
      return human.status();
    }
    answer.parts.push_back({"human", "png", *std::move(human), size(human_size_px)});
  }
  return answer;
}

absl::StatusOr<std::unique_ptr<Play>> Play::Start(std::shared_ptr<procgen_client::Client> client,
                                                  const LevelChoice& choice,
                                                  int32_t human_size_px) {
  absl::StatusOr<std::unique_ptr<SingleEnvPool>> pool =
      SingleEnvPool::Make(client, "play", SpecOf(choice));
  if (!pool.ok()) {
    return pool.status();
  }
  absl::StatusOr<Recording> recording = RecordingOf(**pool);
  if (!recording.ok()) {
    return recording.status();
  }
  std::unique_ptr<Play> play(
      new Play(std::move(client), choice, human_size_px, *std::move(pool), *std::move(recording)));
  if (absl::Status status = play->Begin(); !status.ok()) {
    return status;
  }
  return play;
}

absl::StatusOr<std::unique_ptr<Play>> Play::Continue(std::shared_ptr<procgen_client::Client> client,
                                                     Branch branch, int32_t human_size_px) {
  absl::StatusOr<std::unique_ptr<SingleEnvPool>> pool =
      SingleEnvPool::Make(client, "play", branch.spec);
  if (!pool.ok()) {
    return pool.status();
  }
  if (absl::Status status = (*pool)->Restore(branch.state); !status.ok()) {
    return status;
  }
  std::unique_ptr<Play> play(new Play(std::move(client), LevelOf(branch), human_size_px,
                                      *std::move(pool), std::move(branch.recording)));
  play->row_ = std::move(branch.row);
  play->SetStart(std::move(branch.state));
  return play;
}

Play::Play(std::shared_ptr<procgen_client::Client> client, LevelChoice choice,
           int32_t human_size_px, std::unique_ptr<SingleEnvPool> pool, Recording recording)
    : client_(std::move(client)),
      choice_(std::move(choice)),
      human_size_px_(human_size_px),
      pool_(std::move(pool)),
      recording_(std::move(recording)),
      start_recording_(recording_) {}

absl::Status Play::Begin() {
  absl::StatusOr<v1::State> start = pool_->Save();
  if (!start.ok()) {
    return start.status();
  }
  absl::StatusOr<Row> row = pool_->Observe();
  if (!row.ok()) {
    return row.status();
  }
  row_ = *std::move(row);
  recording_.Begin(row_);
  SetStart(*std::move(start));
  return absl::OkStatus();
}

void Play::SetStart(v1::State state) {
  start_ = std::move(state);
  start_recording_ = recording_;
  start_row_ = row_;
}

absl::StatusOr<Answer> Play::View() {
  return ViewAnswer(recording_.ViewOf(recording_.row_count() - 1), row_, pool_.get(),
                    human_size_px_);
}

absl::StatusOr<Answer> Play::Step(int32_t action) {
  if (recording_.row_count() > kStepsMax) {
    return absl::ResourceExhaustedError(
        absl::StrCat("the recording has ", kStepsMax, " steps, which is the limit; restart"));
  }
  absl::StatusOr<Row> row = pool_->Step(action, human_size_px_);
  if (!row.ok()) {
    return row.status();
  }
  row_ = *std::move(row);
  recording_.Add(action, row_);
  return View();
}

absl::StatusOr<Answer> Play::Restart() {
  if (absl::Status status = pool_->Restore(start_); !status.ok()) {
    return status;
  }
  recording_ = start_recording_;
  row_ = start_row_;
  return View();
}

absl::StatusOr<Answer> Play::NextLevel() {
  if (choice_.has_one_level || choice_.level_seed == kLevelSeedMax) {
    return absl::FailedPreconditionError(
        absl::StrCat("level ", choice_.level_seed,
                     choice_.has_one_level ? " is the only one of this mode" : " is the last one"));
  }
  LevelChoice next = choice_;
  ++next.level_seed;
  absl::StatusOr<std::unique_ptr<SingleEnvPool>> pool =
      SingleEnvPool::Make(client_, "play", SpecOf(next));
  if (!pool.ok()) {
    return pool.status();
  }
  absl::StatusOr<Recording> recording = RecordingOf(**pool);
  if (!recording.ok()) {
    return recording.status();
  }
  choice_ = std::move(next);
  pool_ = *std::move(pool);
  recording_ = *std::move(recording);
  if (absl::Status status = Begin(); !status.ok()) {
    return status;
  }
  return View();
}

}  // namespace procgen::web
