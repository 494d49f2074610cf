#include "server/pool/watch/frame_publisher.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/time/clock.h"
#include "server/concurrency/deadline_timer.h"

namespace procgen {
namespace {

constexpr size_t kAgentViewBytes = kObservationBytes;

absl::Span<uint8_t> PixelsOf(std::string* image) {
  return absl::MakeSpan(reinterpret_cast<uint8_t*>(image->data()), image->size());
}

}  // namespace

FramePublisher::FramePublisher(std::shared_ptr<PoolSession> pool, WatchSpec spec,
                               FrameSetEncoder encode, BackgroundExecutor* drawing)
    : pool_(std::move(pool)),
      spec_(std::move(spec)),
      encode_(std::move(encode)),
      drawing_(drawing),
      can_copy_(spec_.size_px == kObservationSizePx &&
                pool_->options().observation_format.frame == FrameFormat()),
      endings_(spec_.environments.size()),
      showed_end_(spec_.environments.size()),
      steps_(spec_.with_steps ? spec_.environments.size() : 0) {}

std::optional<absl::Cord> FramePublisher::Subscribe(std::shared_ptr<FrameSubscriber> subscriber) {
  absl::MutexLock lock(&mutex_);
  if (ended_) {
    return std::nullopt;
  }
  subscribers_.push_back(std::move(subscriber));
  if (busy_) {
    return absl::Cord();  // the frame set being drawn follows
  }
  if (latest_.empty() || shown_ != NumbersNow()) {
    at_once_ = true;
    due_ = absl::InfinitePast();
    return absl::Cord();
  }
  return latest_;
}

bool FramePublisher::Unsubscribe(const FrameSubscriber* subscriber) {
  absl::MutexLock lock(&mutex_);
  std::erase_if(subscribers_, [subscriber](const auto& each) { return each.get() == subscriber; });
  return subscribers_.empty();
}

FramePublisher::Numbers FramePublisher::NumbersNow() const {
  return {pool_->request_count(), pool_->change_number()};
}

bool FramePublisher::HasReadySubscriber() const {
  return std::any_of(subscribers_.begin(), subscribers_.end(),
                     [](const std::shared_ptr<FrameSubscriber>& each) { return each->IsReady(); });
}

absl::Time FramePublisher::Tick(absl::Time now) {
  absl::Time next;
  {
    absl::MutexLock lock(&mutex_);
    if (ended_ || subscribers_.empty()) {
      return absl::InfiniteFuture();
    }
    if (now < due_) {
      return due_;
    }
    const bool takes_turn = BeginTick(now);
    next = due_;
    if (!takes_turn) {
      return next;
    }
    waits_for_turn_ = true;
  }
  pool_->TakeTurn([self = shared_from_this()](const absl::Status& turn) { self->OnTurn(turn); });
  return next;
}

bool FramePublisher::BeginTick(absl::Time now) {
  due_ = std::max(due_, now - spec_.interval) + spec_.interval;
  if (busy_ || waits_for_turn_ || !HasReadySubscriber()) {
    return false;
  }
  if (can_copy_ && !armed_) {
    Arm();
    if (!at_once_ && copy_came_) {
      return false;
    }
  }
  if (!at_once_ && shown_ == NumbersNow()) {
    return false;
  }
  // Copies arrive with the learner's requests. A turn is needed for the last frame set before the
  // learner pauses, and for learners that do not observe.
  const absl::Time from =
      at_once_ ? pool_->next_capture_time() : std::max(pool_->next_capture_time(), rests_until_);
  if (now < from) {
    due_ = std::min(due_, from);
    return false;
  }
  return true;
}

void FramePublisher::Arm() {
  armed_ = true;
  copied_.resize(spec_.environments.size());
  for (std::string& image : copied_) {
    image.resize(kAgentViewBytes);
  }
  seen_.assign(spec_.environments.size(), false);
}

void FramePublisher::OnTurn(const absl::Status& turn) {
  bool captures = turn.ok();
  {
    absl::MutexLock lock(&mutex_);
    waits_for_turn_ = false;
    // The previous request may have shown all environments.
    captures = captures && !ended_ && !busy_ && (at_once_ || shown_ != NumbersNow());
    if (captures) {
      busy_ = true;
      armed_ = false;
      copy_came_ = false;
      shown_ = NumbersNow();
    }
  }
  if (!captures) {
    if (turn.ok()) {
      pool_->EndTurn();
    }
    return;
  }
  const View view = spec_.size_px == kObservationSizePx ? View::kAgent : View::kHuman;
  pool_->CaptureScenes(
      spec_.environments, view, spec_.size_px,
      [self = shared_from_this(), begin_time = SteadyNow()](absl::StatusOr<Draw> draw) {
        self->OnCaptured(std::move(draw), begin_time);
      });
}

FramePublisher::Plan FramePublisher::BeginFrameSet(int64_t request_count) {
  const size_t count = spec_.environments.size();
  Plan plan = {.frame_set = {.environments = spec_.environments,
                             .images = {},
                             .agent_images = {},
                             .ended_episodes = {},
                             .steps = steps_,
                             .size_px = spec_.size_px,
                             .request_count = request_count,
                             .time = absl::Now()},
               .final_scenes = {}};
  plan.frame_set.ended_episodes.resize(count);
  plan.final_scenes.resize(count);
  for (size_t i = 0; i < count; ++i) {
    std::optional<Ending>& ending = endings_[i];
    if (showed_end_[i] || ending.has_value()) {
      shown_ = {};  // another frame set is needed even if the pool does not change
    }
    showed_end_[i] = !showed_end_[i] && ending.has_value();
    if (showed_end_[i]) {
      plan.frame_set.ended_episodes[i] = ending->episode;
      if (spec_.with_steps) {
        plan.frame_set.steps[i] = std::move(ending->last_step);
      }
      plan.final_scenes[i] = std::move(ending->scene);
      ending.reset();
    }
  }
  return plan;
}

void FramePublisher::DrawFinalScenes(Plan* plan) {
  std::optional<SceneSnapshotRenderer> renderer;
  for (size_t i = 0; i < plan->final_scenes.size(); ++i) {
    const SceneSnapshot* const scene = plan->final_scenes[i].get();
    if (scene == nullptr) {
      continue;
    }
    if (!renderer.has_value()) {
      renderer.emplace();
    }
    const absl::Span<uint8_t> frame = PixelsOf(&plan->frame_set.images[i]);
    if (plan->frame_set.size_px == kObservationSizePx) {
      renderer->DrawAgentView(*scene, frame);
    } else {
      renderer->DrawHumanView(*scene, plan->frame_set.size_px, frame);
    }
    if (!plan->frame_set.agent_images.empty()) {
      renderer->DrawAgentView(*scene, PixelsOf(&plan->frame_set.agent_images[i]));
    }
  }
}

void FramePublisher::OnCaptured(absl::StatusOr<Draw> draw, absl::Time begin_time) {
  Plan plan;
  {
    absl::MutexLock lock(&mutex_);
    if (draw.ok()) {
      plan = BeginFrameSet(pool_->request_count());
    } else {
      busy_ = false;
      shown_ = {};
    }
  }
  pool_->NoteCapture(begin_time);
  pool_->EndTurn();
  if (!draw.ok()) {
    return;
  }
  drawing_->Run(pool_->owner(), [self = shared_from_this(), plan = std::move(plan),
                                 draw = *std::move(draw)]() mutable {
    const CpuThrottle throttle;
    FrameSet& frame_set = plan.frame_set;
    const int64_t request_count = frame_set.request_count;
    const auto size_px = static_cast<size_t>(self->spec_.size_px);
    std::vector<absl::Span<uint8_t>> frames;
    frame_set.images.resize(frame_set.environments.size());
    for (std::string& image : frame_set.images) {
      image.resize(size_px * size_px * 3);
      frames.push_back(PixelsOf(&image));
    }
    frame_set.agent_images.resize(self->spec_.with_agent_views ? frame_set.environments.size() : 0);
    for (std::string& image : frame_set.agent_images) {
      image.resize(kAgentViewBytes);
      frames.push_back(PixelsOf(&image));
    }
    draw(frames);
    DrawFinalScenes(&plan);
    self->Deliver(std::move(frame_set));
    self->Rest(request_count, throttle);
  });
}

void FramePublisher::Rest(int64_t request_count, const CpuThrottle& throttle) {
  if (pool_->request_count() == request_count) {
    return;  // the learner is idle: no need to rest
  }
  absl::MutexLock lock(&mutex_);
  rests_until_ = SteadyNow() + throttle.RestDue();
}

void FramePublisher::Deliver(FrameSet frame_set) {
  const absl::Cord encoded = encode_(std::move(frame_set));
  std::vector<std::shared_ptr<FrameSubscriber>> subscribers;
  {
    absl::MutexLock lock(&mutex_);
    busy_ = false;
    at_once_ = false;
    latest_ = encoded;
    subscribers = subscribers_;
  }
  for (const std::shared_ptr<FrameSubscriber>& subscriber : subscribers) {
    subscriber->Take(encoded);
  }
}

void FramePublisher::Note(const Request& request, const StepInput& input, const Batch& batch) {
  for (size_t i = 0; i < spec_.environments.size(); ++i) {
    const int32_t offset = spec_.environments[i] - input.first;
    if (offset < 0 || offset >= input.count) {
      continue;
    }
    const auto row = static_cast<size_t>(offset);
    if (armed_ && !busy_) {
      CopyObservation(i, row, input, batch);
    }
    if (input.steps || !input.resets.empty()) {
      NoteStep(i, row, request, input, batch);
    }
  }
}

void FramePublisher::CopyObservation(size_t i, size_t row, const StepInput& input,
                                     const Batch& batch) {
  seen_[i] = !batch.observations.empty();
  if (seen_[i]) {
    // The last frame of a stack.
    const size_t row_bytes = batch.observations.size() / static_cast<size_t>(input.count);
    const size_t end = (row + 1) * row_bytes;
    std::memcpy(copied_[i].data(), batch.observations.data() + end - kAgentViewBytes,
                kAgentViewBytes);
  }
}

void FramePublisher::NoteStep(size_t i, size_t row, const Request& request, const StepInput& input,
                              const Batch& batch) {
  if (!spec_.with_steps) {
    NoteEnd(i, row, batch, nullptr);
    return;
  }
  std::optional<EnvironmentStep>& step = steps_[i];
  if (input.steps) {
    const bool ended = batch.terminated[row] != 0 || batch.truncated[row] != 0;
    if (!step.has_value()) {
      step.emplace();
    }
    step->action = input.actions[row];
    step->reward = batch.rewards[row];
    step->episode_return = batch.episode_returns[row];
    step->episode_length = batch.episode_lengths[row];
    step->level_seed = ended ? batch.prev_level_seeds[row] : batch.level_seeds[row];
    CopyAnnotations(request.annotations, request.count,
                    static_cast<size_t>(spec_.environments[i] - request.first), &step->annotations);
    NoteEnd(i, row, batch, &*step);
  }
  if (batch.first[row] != 0) {
    step.emplace().level_seed = batch.level_seeds[row];
  }
}

void FramePublisher::NoteEnd(size_t i, size_t row, const Batch& batch,
                             const EnvironmentStep* last_step) {
  const int32_t environment = spec_.environments[i];
  const auto* const final_scene = std::lower_bound(
      batch.final_scenes.begin(), batch.final_scenes.end(), environment,
      [](const FinalScene& each, int32_t number) { return each.environment < number; });
  if (final_scene == batch.final_scenes.end() || final_scene->environment != environment ||
      final_scene->scene == nullptr) {
    return;
  }
  endings_[i] = {.episode = {.episode_return = batch.episode_returns[row],
                             .length = batch.episode_lengths[row],
                             .level_seed = batch.prev_level_seeds[row],
                             .level_complete = batch.prev_level_complete[row] != 0,
                             .truncated = batch.truncated[row] != 0},
                 .last_step = last_step == nullptr ? EnvironmentStep() : *last_step,
                 .scene = final_scene->scene};
}

void FramePublisher::OnExecuted(const Request& request, const StepInput& input, const Batch& batch,
                                int64_t request_count, int64_t change_number) {
  Plan plan;
  {
    absl::MutexLock lock(&mutex_);
    Note(request, input, batch);
    if (!armed_ || busy_ || std::find(seen_.begin(), seen_.end(), false) != seen_.end()) {
      return;
    }
    armed_ = false;
    busy_ = true;
    copy_came_ = true;
    shown_ = {request_count, change_number};
    plan = BeginFrameSet(request_count);
    plan.frame_set.images = std::exchange(copied_, {});
  }
  drawing_->Run(pool_->owner(), [self = shared_from_this(), plan = std::move(plan)]() mutable {
    DrawFinalScenes(&plan);
    self->Deliver(std::move(plan.frame_set));
  });
}

void FramePublisher::OnInvalidated() {
  absl::MutexLock lock(&mutex_);
  seen_.assign(seen_.size(), false);
  endings_.assign(endings_.size(), std::nullopt);
  steps_.assign(steps_.size(), std::nullopt);
}

void FramePublisher::OnEnd(const absl::Status& reason) {
  std::vector<std::shared_ptr<FrameSubscriber>> subscribers;
  {
    absl::MutexLock lock(&mutex_);
    ended_ = true;
    subscribers = subscribers_;
  }
  for (const std::shared_ptr<FrameSubscriber>& subscriber : subscribers) {
    subscriber->End(reason);
  }
}

}  // namespace procgen
