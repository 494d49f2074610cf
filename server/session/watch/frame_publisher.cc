#include "server/session/watch/frame_publisher.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/time/clock.h"
#include "server/concurrency/deadline_timer.h"

namespace procgen {
namespace {

constexpr size_t kAgentViewBytes = kObservationBytes;

}  // namespace

FramePublisher::FramePublisher(std::shared_ptr<PoolSession> pool, WatchSpec spec,
                               FrameSetEncoder encode, BackgroundExecutor* drawing)
    : pool_(std::move(pool)),
      spec_(std::move(spec)),
      encode_(std::move(encode)),
      drawing_(drawing),
      can_copy_(spec_.size_px == kObservationSizePx &&
                pool_->options().observation_format.frame == FrameFormat()) {}

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
  return {pool_->next_sequence_number() - 1, pool_->change_number()};
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
  pool_->CaptureScenes(spec_.environments, view, spec_.size_px,
                       [self = shared_from_this(),
                        begin_time = SteadyNow()](absl::StatusOr<PoolBackend::Draw> draw) {
                         self->OnCaptured(std::move(draw), begin_time);
                       });
}

FrameSet FramePublisher::BeginFrameSet() const {
  return {.environments = spec_.environments,
          .images = {},
          .size_px = spec_.size_px,
          .sequence_number = 0,
          .time = absl::Now()};
}

void FramePublisher::OnCaptured(absl::StatusOr<PoolBackend::Draw> draw, absl::Time begin_time) {
  FrameSet frame_set = BeginFrameSet();
  frame_set.sequence_number = pool_->next_sequence_number() - 1;
  pool_->NoteCapture(begin_time);
  pool_->EndTurn();
  if (!draw.ok()) {
    absl::MutexLock lock(&mutex_);
    busy_ = false;
    shown_ = {};
    return;
  }
  drawing_->Run(pool_->owner(), [self = shared_from_this(), frame_set = std::move(frame_set),
                                 draw = *std::move(draw)]() mutable {
    const CpuThrottle throttle;
    const int64_t sequence_number = frame_set.sequence_number;
    const auto size_px = static_cast<size_t>(self->spec_.size_px);
    std::vector<absl::Span<uint8_t>> frames;
    frame_set.images.resize(frame_set.environments.size());
    for (std::string& image : frame_set.images) {
      image.resize(size_px * size_px * 3);
      frames.push_back(absl::MakeSpan(reinterpret_cast<uint8_t*>(image.data()), image.size()));
    }
    draw(frames);
    self->Deliver(std::move(frame_set));
    self->Rest(sequence_number, throttle);
  });
}

void FramePublisher::Rest(int64_t sequence_number, const CpuThrottle& throttle) {
  if (pool_->next_sequence_number() - 1 == sequence_number) {
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

void FramePublisher::OnPart(Part part, absl::Span<const uint8_t> observations) {
  absl::MutexLock lock(&mutex_);
  if (!armed_ || busy_) {
    return;
  }
  const size_t row_bytes = observations.size() / static_cast<size_t>(part.count);
  for (size_t i = 0; i < seen_.size(); ++i) {
    const int32_t row = spec_.environments[i] - part.first;
    if (row < 0 || row >= part.count) {
      continue;
    }
    seen_[i] = !observations.empty();
    if (seen_[i]) {
      // The last frame of a stack.
      const size_t end = (static_cast<size_t>(row) + 1) * row_bytes;
      std::memcpy(copied_[i].data(), observations.data() + end - kAgentViewBytes, kAgentViewBytes);
    }
  }
}

void FramePublisher::OnRequestEnd(int64_t sequence_number, int64_t change_number) {
  FrameSet frame_set;
  {
    absl::MutexLock lock(&mutex_);
    if (!armed_ || busy_ || std::find(seen_.begin(), seen_.end(), false) != seen_.end()) {
      return;
    }
    armed_ = false;
    busy_ = true;
    copy_came_ = true;
    shown_ = {sequence_number, change_number};
    frame_set = BeginFrameSet();
    frame_set.sequence_number = sequence_number;
    frame_set.images = std::exchange(copied_, {});
  }
  drawing_->Run(pool_->owner(),
                [self = shared_from_this(), frame_set = std::move(frame_set)]() mutable {
                  self->Deliver(std::move(frame_set));
                });
}

void FramePublisher::OnInvalidated() {
  absl::MutexLock lock(&mutex_);
  seen_.assign(seen_.size(), false);
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
