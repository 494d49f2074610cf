#include "server/pool/episodes/episode_log.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

// Memory limit of a pool: a part per environment, plus a constant. The longest episodes have 6,000
// steps, and two of them are kept.
constexpr int64_t kEnvironmentBytesMax = 20 << 10;
constexpr int64_t kPoolBytesMin = 1 << 20;
// Memory limit of the annotations of a pool.
constexpr int64_t kAnnotationBytesMax = 32 << 20;
// The smallest buffer.
constexpr int64_t kBufferBytesMin = 64;

// Sets why the beginning is missing; the first reason wins.
void SetReason(IncompleteReason reason, EpisodeRecording* recording) {
  if (recording->summary.incomplete_reason == IncompleteReason::kNone) {
    recording->summary.incomplete_reason = reason;
  }
}

// A map of 64 x 64 as one of 16 x 16: the means of blocks of 4 x 4.
std::vector<float> CoarseMapOf(absl::Span<const float> map) {
  constexpr size_t kSide = 64;
  constexpr size_t kBlock = 4;
  std::vector<float> coarse(kSaliencyRecordedMax);
  for (size_t i = 0; i < map.size(); ++i) {
    const size_t row = i / kSide / kBlock;
    const size_t column = i % kSide / kBlock;
    coarse[row * (kSide / kBlock) + column] += map[i] / static_cast<float>(kBlock * kBlock);
  }
  return coarse;
}

bool HasEnded(const Batch& batch, size_t row) {
  return (batch.terminated[row] | batch.truncated[row]) != 0;
}

}  // namespace

EpisodeLog::EpisodeLog(int32_t env_count, ByteBudget* bytes)
    : bytes_(bytes),
      bytes_max_(kPoolBytesMin + env_count * kEnvironmentBytesMax),
      environments_(static_cast<size_t>(env_count)),
      lengths_(static_cast<size_t>(env_count)),
      returns_(static_cast<size_t>(env_count)) {}

EpisodeLog::~EpisodeLog() { bytes_->Change(reserved_bytes_ + annotation_bytes_, 0); }

void EpisodeLog::Add(const StepInput& input, const Batch& batch,
                     const StepAnnotations& annotations) {
  const auto first = static_cast<size_t>(input.first);
  const auto count = static_cast<size_t>(input.count);
  for (size_t row = 0; input.steps && row < count; ++row) {
    // Fast path: most rows are an action and perhaps a reward.
    const bool is_plain =
        annotations.annotations.empty() && (batch.terminated[row] | batch.truncated[row] |
                                            batch.first[row] | batch.prev_level_complete[row]) == 0;
    Environment& environment = environments_[first + row];
    if (is_plain && input.repeat == 1 && environment.current.HasRoom() && environment.knows_level) {
      environment.current.AddStep(input.actions[row], 1, batch.rewards[row]);
    } else {
      AddStep(input, batch, annotations, row);
    }
  }
  if (!input.steps) {
    // In all other rows the arrays hold stale values.
    for (const Reset& reset : input.resets) {
      AddBoundary(reset.environment, batch, static_cast<size_t>(reset.environment - input.first));
    }
  }
  for (size_t row = 0; row < count; ++row) {
    const bool begins = batch.first[row] != 0;
    lengths_[first + row] = begins ? 0 : batch.episode_lengths[row];
    returns_[first + row] = begins ? 0 : batch.episode_returns[row];
  }
}

void EpisodeLog::AddStep(const StepInput& input, const Batch& batch,
                         const StepAnnotations& annotations, size_t row) {
  const int32_t index = input.first + static_cast<int32_t>(row);
  Environment& environment = Of(index);
  if (!environment.knows_level) {
    SetLevel(index, batch.prev_level_seeds[row]);
  }
  const bool ended = HasEnded(batch, row);
  const bool begins = batch.first[row] != 0;
  if (!environment.current.HasRoom()) {
    MakeRoom(&environment);
  }
  if (environment.current.HasRoom() && (ended || !begins)) {
    int32_t count = input.repeat;
    if (const int32_t before = lengths_[static_cast<size_t>(index)]; count > 1 && before >= 0) {
      count = std::clamp(batch.episode_lengths[row] - before, 0, count);
    }
    environment.current.AddStep(input.actions[row], count, batch.rewards[row]);
    if (!annotations.annotations.empty()) {
      AddAnnotations(annotations, index);
    }
    if (!ended && batch.prev_level_complete[row] != 0) {
      environment.current.AddLevel(batch.level_seeds[row]);
    }
  }
  if (ended || begins) {
    AddBoundary(index, batch, row);
  }
}

void EpisodeLog::AddAnnotations(const StepAnnotations& annotations, int32_t index) {
  step_annotations_.clear();
  for (const Annotation& annotation : annotations.annotations) {
    const size_t count = annotation.values.size() / static_cast<size_t>(annotations.count);
    absl::Span<const float> values =
        annotation.values.subspan(static_cast<size_t>(index - annotations.first) * count, count);
    if (count == kSaliencyValuesMax) {
      coarse_map_ = CoarseMapOf(values);
      values = coarse_map_;
    }
    if (values.size() <= kSaliencyRecordedMax) {  // larger ones are not recorded
      step_annotations_.push_back({annotation.name, values});
    }
  }
  Environment& environment = Of(index);
  AnnotationRecording& current = environment.current.annotations;
  const int32_t step = environment.current.step_count() - 1;
  while (!ReserveAnnotations(current.GrowthBytes(step, step_annotations_))) {
    if (AnnotationRecording& last = environment.last.annotations; last.bytes() > 0) {
      ReleaseAnnotations(last.bytes());
      last.Clear();
    } else if (const int64_t bytes = current.bytes(); bytes > 0) {
      current.DropOlderHalf();
      ReleaseAnnotations(bytes - current.bytes());
    } else {
      return;
    }
  }
  const int64_t reserved = current.bytes() + current.GrowthBytes(step, step_annotations_);
  current.Add(step, step_annotations_);
  ReleaseAnnotations(reserved - current.bytes());
}

bool EpisodeLog::ReserveAnnotations(int64_t bytes) {
  if (bytes > 0 && (annotation_bytes_ + bytes > kAnnotationBytesMax ||
                    bytes_->reserved_bytes() + bytes > bytes_->bytes_max() / 2 ||
                    !bytes_->Change(annotation_bytes_, annotation_bytes_ + bytes))) {
    return false;
  }
  annotation_bytes_ += bytes;
  return true;
}

void EpisodeLog::ReleaseAnnotations(int64_t bytes) {
  bytes_->Change(annotation_bytes_, annotation_bytes_ - bytes);
  annotation_bytes_ -= bytes;
}

bool EpisodeLog::DropAnnotations(Environment* environment) {
  AnnotationRecording& last = environment->last.annotations;
  AnnotationRecording& dropped = last.bytes() > 0 ? last : environment->current.annotations;
  const int64_t bytes = dropped.bytes();
  dropped.Clear();
  ReleaseAnnotations(bytes);
  return bytes > 0;
}

void EpisodeLog::ClearSteps(EpisodeRecording* recording) {
  const int64_t bytes = recording->annotations.bytes();
  recording->ClearSteps();
  ReleaseAnnotations(bytes - recording->annotations.bytes());
}

void EpisodeLog::Forget(EpisodeRecording* recording, int64_t bytes) {
  const int64_t annotation_bytes = recording->annotations.bytes();
  if (recording->KeepLast(bytes)) {
    SetReason(IncompleteReason::kTooOld, recording);
  }
  ReleaseAnnotations(annotation_bytes - recording->annotations.bytes());
}

void EpisodeLog::AddBoundary(int32_t index, const Batch& batch, size_t row) {
  Environment& environment = Of(index);
  EpisodeSummary& summary = environment.current.summary;
  const auto place = static_cast<size_t>(index);
  const bool begins = batch.first[row] != 0;
  if (HasEnded(batch, row)) {
    summary.outcome =
        batch.terminated[row] != 0 ? EpisodeOutcome::kTerminated : EpisodeOutcome::kTruncated;
    summary.level_complete = batch.prev_level_complete[row] != 0;
    summary.fingerprint = batch.fingerprints[row];
    summary.total_reward = batch.episode_returns[row];
    EndEpisode(&environment);
  } else if (begins && environment.is_under_way && lengths_[place] != 0) {
    summary.outcome = EpisodeOutcome::kReset;
    summary.total_reward = returns_[place];
    EndEpisode(&environment);
  }
  if (begins) {
    BeginEpisode(index, batch.level_seeds[row]);
  }
}

void EpisodeLog::EndEpisode(Environment* environment) {
  std::swap(environment->current, environment->last);
  const EpisodeSummary& last = environment->last.summary;
  environment->current.summary = {.options = last.options,
                                  .prev_level_incomplete = !last.level_complete};
  ClearSteps(&environment->current);
  environment->is_under_way = false;
  environment->has_last = true;
}

void EpisodeLog::BeginEpisode(int32_t environment, int32_t level_seed) {
  SetLevel(environment, level_seed);
  Environment& of = Of(environment);
  of.current.summary.incomplete_reason = IncompleteReason::kNone;
  ClearSteps(&of.current);
  of.is_under_way = true;
}

void EpisodeLog::SetLevel(int32_t environment, int32_t level_seed) {
  Of(environment).knows_level = true;
  Of(environment).current.summary.level_seed = level_seed;
}

void EpisodeLog::Add(absl::Span<const RestoredState> states) {
  for (const RestoredState& state : states) {
    BeginEpisode(state.environment, state.level_seed);
    Environment& environment = Of(state.environment);
    EpisodeSummary& summary = environment.current.summary;
    summary.prev_level_incomplete = state.prev_level_incomplete;
    summary.options = state.options;
    summary.incomplete_reason =
        state.episode_length == 0 ? IncompleteReason::kNone : IncompleteReason::kStateRestored;
    environment.is_under_way = !state.awaits_episode;
    lengths_[static_cast<size_t>(state.environment)] = state.episode_length;
    returns_[static_cast<size_t>(state.environment)] = 0;
  }
}

void EpisodeLog::Add(absl::Span<const StateToClone> pairs) {
  struct Source {
    EpisodeSummary summary;
    int32_t length = 0;
    bool knows_level = false;
    bool is_under_way = true;
  };
  std::vector<Source> sources;
  sources.reserve(pairs.size());
  for (const StateToClone& pair : pairs) {
    const Environment& source = Of(pair.source_environment);
    sources.push_back({source.current.summary,
                       lengths_[static_cast<size_t>(pair.source_environment)], source.knows_level,
                       source.is_under_way});
  }
  for (size_t i = 0; i < pairs.size(); ++i) {
    const auto place = static_cast<size_t>(pairs[i].target_environment);
    Environment& target = environments_[place];
    EpisodeSummary& summary = target.current.summary;
    summary = std::move(sources[i].summary);
    if (sources[i].length != 0) {
      summary.incomplete_reason = IncompleteReason::kStateRestored;
    }
    ClearSteps(&target.current);
    lengths_[place] = sources[i].length;
    returns_[place] = 0;
    target.knows_level = sources[i].knows_level;
    target.is_under_way = sources[i].is_under_way;
  }
}

absl::StatusOr<EpisodeRecording> EpisodeLog::Read(int32_t environment, bool under_way) const {
  const Environment& of = Of(environment);
  if (under_way ? !of.is_under_way : !of.has_last) {
    return absl::FailedPreconditionError(absl::StrCat(
        "environment ", environment,
        under_way ? " is between two episodes: the last one has ended, and the next has not begun"
                  : " has ended no episode yet"));
  }
  EpisodeRecording read = under_way ? of.current : of.last;
  if (under_way) {
    read.summary.total_reward = returns_[static_cast<size_t>(environment)];
  }
  return read;
}

void EpisodeLog::MakeRoom(Environment* environment) {
  EpisodeRecording& current = environment->current;
  EpisodeRecording& last = environment->last;
  while (!Reallocate(&current, std::max(kBufferBytesMin, 2 * current.capacity()))) {
    if (DropAnnotations(environment)) {
      continue;
    }
    if (last.capacity() > 0) {
      const int64_t half = last.capacity() > kBufferBytesMin ? last.capacity() / 2 : 0;
      Forget(&last, half);
      Reallocate(&last, half);
    } else if (current.capacity() > 0) {
      Forget(&current, current.capacity() / 2);
      return;
    } else {
      SetReason(IncompleteReason::kTooOld, &current);
      return;
    }
  }
}

bool EpisodeLog::Reallocate(EpisodeRecording* recording, int64_t capacity) {
  const int64_t reserved = reserved_bytes_ - recording->capacity() + capacity;
  if ((reserved > reserved_bytes_ && reserved > bytes_max_) ||
      !bytes_->Change(reserved_bytes_, reserved)) {
    return false;
  }
  reserved_bytes_ = reserved;
  recording->Reallocate(capacity);
  return true;
}

}  // namespace procgen
