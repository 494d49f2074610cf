#include "server/session/watch/pool_view.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/time/clock.h"
#include "server/concurrency/deadline_timer.h"

namespace procgen {
namespace {

constexpr size_t kAgentViewBytes = kObservationBytes;

}  // namespace

PoolView::PoolView(std::shared_ptr<PoolSession> pool, WatchOrder order, EncodeMoment encode,
                   BackgroundExecutor* drawing)
    : pool_(std::move(pool)),
      order_(std::move(order)),
      encode_(std::move(encode)),
      drawing_(drawing),
      can_copy_(order_.size_px == kObservationSizePx &&
                pool_->options().observation_format.frame == FrameFormat()) {}

std::optional<absl::Cord> PoolView::Join(std::shared_ptr<Watcher> watcher) {
  absl::MutexLock lock(&mutex_);
  if (ended_) {
    return std::nullopt;
  }
  watchers_.push_back(std::move(watcher));
  if (busy_) {
    return absl::Cord();  // it is given what is being drawn
  }
  if (latest_.empty() || shown_ != NumbersNow()) {
    at_once_ = true;
    due_ = absl::InfinitePast();
    return absl::Cord();
  }
  return latest_;
}

bool PoolView::Leave(const Watcher* watcher) {
  absl::MutexLock lock(&mutex_);
  std::erase_if(watchers_, [watcher](const auto& each) { return each.get() == watcher; });
  return watchers_.empty();
}

PoolView::Numbers PoolView::NumbersNow() const {
  return {pool_->next_sequence_number() - 1, pool_->change_number()};
}

bool PoolView::HasReadyWatcher() const {
  return std::any_of(watchers_.begin(), watchers_.end(),
                     [](const std::shared_ptr<Watcher>& each) { return each->IsReady(); });
}

absl::Time PoolView::Tick(absl::Time now) {
  absl::Time next;
  {
    absl::MutexLock lock(&mutex_);
    if (ended_ || watchers_.empty()) {
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

bool PoolView::BeginTick(absl::Time now) {
  due_ = std::max(due_, now - order_.interval) + order_.interval;
  if (busy_ || waits_for_turn_ || !HasReadyWatcher()) {
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
  // What can be copied comes by itself while the learner goes on; a turn is for the last moment
  // before it pauses, and for learners who do not look.
  const absl::Time from =
      at_once_ ? pool_->next_capture_time() : std::max(pool_->next_capture_time(), rests_until_);
  if (now < from) {
    due_ = std::min(due_, from);
    return false;
  }
  return true;
}

void PoolView::Arm() {
  armed_ = true;
  copied_.resize(order_.environments.size());
  for (std::string& image : copied_) {
    image.resize(kAgentViewBytes);
  }
  seen_.assign(order_.environments.size(), false);
}

void PoolView::OnTurn(const absl::Status& turn) {
  bool captures = turn.ok();
  {
    absl::MutexLock lock(&mutex_);
    waits_for_turn_ = false;
    // The request before may have shown all that is wanted.
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
  const View view = order_.size_px == kObservationSizePx ? View::kAgent : View::kHuman;
  pool_->CaptureScenes(
      order_.environments, view, order_.size_px,
      [self = shared_from_this(), begin_time = SteadyNow()](absl::StatusOr<HostedPool::Draw> draw) {
        self->OnCaptured(std::move(draw), begin_time);
      });
}

Moment PoolView::BeginMoment() const {
  return {.environments = order_.environments,
          .images = {},
          .size_px = order_.size_px,
          .sequence_number = 0,
          .time = absl::Now()};
}

void PoolView::OnCaptured(absl::StatusOr<HostedPool::Draw> draw, absl::Time begin_time) {
  Moment moment = BeginMoment();
  moment.sequence_number = pool_->next_sequence_number() - 1;
  pool_->NoteCapture(begin_time);
  pool_->EndTurn();
  if (!draw.ok()) {
    absl::MutexLock lock(&mutex_);
    busy_ = false;
    shown_ = {};
    return;
  }
  drawing_->Run(pool_->owner(), [self = shared_from_this(), moment = std::move(moment),
                                 draw = *std::move(draw)]() mutable {
    const CpuThrottle throttle;
    const int64_t sequence_number = moment.sequence_number;
    const auto size_px = static_cast<size_t>(self->order_.size_px);
    std::vector<absl::Span<uint8_t>> frames;
    moment.images.resize(moment.environments.size());
    for (std::string& image : moment.images) {
      image.resize(size_px * size_px * 3);
      frames.push_back(absl::MakeSpan(reinterpret_cast<uint8_t*>(image.data()), image.size()));
    }
    draw(frames);
    self->Deliver(std::move(moment));
    self->Rest(sequence_number, throttle);
  });
}

void PoolView::Rest(int64_t sequence_number, const CpuThrottle& throttle) {
  if (pool_->next_sequence_number() - 1 == sequence_number) {
    return;  // whoever wanted the core, the learner waits
  }
  absl::MutexLock lock(&mutex_);
  rests_until_ = SteadyNow() + throttle.RestDue();
}

void PoolView::Deliver(Moment moment) {
  const absl::Cord encoded = encode_(std::move(moment));
  std::vector<std::shared_ptr<Watcher>> watchers;
  {
    absl::MutexLock lock(&mutex_);
    busy_ = false;
    at_once_ = false;
    latest_ = encoded;
    watchers = watchers_;
  }
  for (const std::shared_ptr<Watcher>& watcher : watchers) {
    watcher->Take(encoded);
  }
}

void PoolView::OnPart(Part part, absl::Span<const uint8_t> observations) {
  absl::MutexLock lock(&mutex_);
  if (!armed_ || busy_) {
    return;
  }
  const size_t row_bytes = observations.size() / static_cast<size_t>(part.count);
  for (size_t i = 0; i < seen_.size(); ++i) {
    const int32_t row = order_.environments[i] - part.first;
    if (row < 0 || row >= part.count) {
      continue;
    }
    seen_[i] = !observations.empty();
    if (seen_[i]) {
      // Of a stack of frames the last one.
      const size_t end = (static_cast<size_t>(row) + 1) * row_bytes;
      std::memcpy(copied_[i].data(), observations.data() + end - kAgentViewBytes, kAgentViewBytes);
    }
  }
}

void PoolView::OnRequestEnd(int64_t sequence_number, int64_t change_number) {
  Moment moment;
  {
    absl::MutexLock lock(&mutex_);
    if (!armed_ || busy_ || std::find(seen_.begin(), seen_.end(), false) != seen_.end()) {
      return;
    }
    armed_ = false;
    busy_ = true;
    copy_came_ = true;
    shown_ = {sequence_number, change_number};
    moment = BeginMoment();
    moment.sequence_number = sequence_number;
    moment.images = std::exchange(copied_, {});
  }
  drawing_->Run(pool_->owner(), [self = shared_from_this(), moment = std::move(moment)]() mutable {
    self->Deliver(std::move(moment));
  });
}

void PoolView::OnInvalidated() {
  absl::MutexLock lock(&mutex_);
  seen_.assign(seen_.size(), false);
}

void PoolView::OnEnd(const absl::Status& reason) {
  std::vector<std::shared_ptr<Watcher>> watchers;
  {
    absl::MutexLock lock(&mutex_);
    ended_ = true;
    watchers = watchers_;
  }
  for (const std::shared_ptr<Watcher>& watcher : watchers) {
    watcher->End(reason);
  }
}

}  // namespace procgen
