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

Play::Play(std::shared_ptr<procgen_client::Client> client, LevelChoice choice,
           int32_t human_size_px, std::unique_ptr<SingleEnvPool> pool, Recording recording)
    : client_(std::move(client)),
      choice_(std::move(choice)),
      human_size_px_(human_size_px),
      pool_(std::move(pool)),
      recording_(std::move(recording)) {}

absl::Status Play::Begin() {
  absl::StatusOr<v1::State> start = pool_->Save();
  if (!start.ok()) {
    return start.status();
  }
  absl::StatusOr<Row> row = pool_->Observe();
  if (!row.ok()) {
    return row.status();
  }
  start_ = *std::move(start);
  row_ = *std::move(row);
  recording_.Begin(row_);
  return absl::OkStatus();
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
  absl::StatusOr<Row> row = pool_->Step(action);
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
  if (absl::Status status = Begin(); !status.ok()) {
    return status;
  }
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
