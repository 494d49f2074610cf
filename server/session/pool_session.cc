#include "server/session/pool_session.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

bool Contains(Part part, int32_t environment) {
  return environment >= part.first && environment < part.first + part.count;
}

// Copies the elements of `list` that belong to `part`.
template <typename Element>
void SelectPart(absl::Span<const Element> list, Part part, std::vector<Element>* selected) {
  selected->clear();
  for (const Element& element : list) {
    if (Contains(part, element.environment)) {
      selected->push_back(element);
    }
  }
}

}  // namespace

PoolSession::PoolSession(std::string owner, std::string name, std::unique_ptr<HostedPool> pool,
                         absl::Duration lease_duration, const PoolSurroundings& surroundings,
                         std::optional<Compression> compression, const SharedFolder* shared_folder)
    : owner_(std::move(owner)),
      name_(std::move(name)),
      pool_(std::move(pool)),
      coding_(pool_->options().observation_format, compression),
      surroundings_(surroundings),
      create_time_(surroundings.lease_alarm->Now()),
      counts_(pool_->options(), surroundings.metrics),
      shared_ring_(shared_folder == nullptr
                       ? nullptr
                       : std::make_unique<SharedRing>(shared_folder, pool_->env_count(),
                                                      observation_bytes())),
      lease_duration_(lease_duration),
      episodes_(
          surroundings.episode_bytes->bytes_max() == 0
              ? nullptr
              : std::make_unique<EpisodeLog>(pool_->env_count(), surroundings.episode_bytes)) {
  absl::MutexLock lock(&mutex_);
  BeginLease();
}

PoolSession::~PoolSession() {
  absl::MutexLock lock(&mutex_);
  surroundings_.kept_answer_bytes->Change(reserved_bytes_, 0);
  if (shared_ring_ != nullptr) {
    surroundings_.shared_memory_bytes->Change(shared_ring_->size_bytes(), 0);
  }
}

bool PoolSession::attached() const {
  absl::MutexLock lock(&mutex_);
  return attached_;
}

bool PoolSession::closed() const {
  absl::MutexLock lock(&mutex_);
  return !closed_.ok();
}

absl::Duration PoolSession::lease_duration() const {
  absl::MutexLock lock(&mutex_);
  return lease_duration_;
}

absl::Time PoolSession::expire_time() const {
  absl::MutexLock lock(&mutex_);
  return expire_time_;
}

int64_t PoolSession::oldest_kept_sequence_number() const {
  absl::MutexLock lock(&mutex_);
  return kept_.OldestOr(next_sequence_number_);
}

void PoolSession::Attach(const AttachOptions& options, EndStream end_stream, Done done) {
  absl::Status status;
  EndStream end_other;
  std::optional<Successor> replaced;
  {
    absl::MutexLock lock(&mutex_);
    status = CheckAttach(options);
    if (status.ok() && !attached_) {
      BeginStream(options, std::move(end_stream));
    } else if (status.ok()) {
      std::swap(replaced, successor_);
      std::swap(end_other, end_stream_);
      successor_ = Successor{options, std::move(end_stream), std::exchange(done, nullptr)};
    }
  }
  const absl::Status taken_over =
      absl::AbortedError(absl::StrCat("another stream took over pool ", name_));
  if (done != nullptr) {
    done(std::move(status));
  }
  if (replaced.has_value()) {
    replaced->done(taken_over);
  }
  if (end_other != nullptr) {
    end_other(StreamEnd::kTakenOver, taken_over);
  }
}

absl::Status PoolSession::CheckAttach(const AttachOptions& options) {
  if (!closed_.ok()) {
    return closed_;
  }
  if (attached_ && !options.take_over) {
    return absl::FailedPreconditionError(absl::StrCat("another stream is attached to pool ", name_,
                                                      ", allowed: one at a time; ",
                                                      options.when_attached));
  }
  if (absl::Status status = CheckHeldBatches(options); !status.ok()) {
    return status;
  }
  Owners::Share share;
  if (!attached_) {
    absl::StatusOr<Owners::Share> taken = surroundings_.owners->Take(owner_, {.stream_count = 1});
    if (!taken.ok()) {
      return taken.status();
    }
    share = *std::move(taken);
  }
  if (options.resumable) {
    if (absl::Status status = ReserveAnswers(options.requests_in_flight_max); !status.ok()) {
      return status;
    }
  }
  if (!attached_) {
    stream_share_ = std::move(share);
  }
  return absl::OkStatus();
}

absl::Status PoolSession::ReserveAnswers(int32_t count) {
  const int64_t bytes = count * AnswerBytesMax();
  ByteBudget* budget = surroundings_.kept_answer_bytes;
  if (bytes > reserved_bytes_ && !budget->Change(reserved_bytes_, bytes)) {
    return absl::ResourceExhaustedError(
        absl::StrCat("attach.resumable keeps ", count, " answers of up to ", AnswerBytesMax(),
                     " bytes, and other pools have ", budget->reserved_bytes() - reserved_bytes_,
                     ", limit kept_answer_bytes_max is ", budget->bytes_max()));
  }
  reserved_bytes_ = std::max(reserved_bytes_, bytes);
  return absl::OkStatus();
}

void PoolSession::TrimReservation() {
  const auto window = [](const AttachOptions& options) {
    return options.resumable ? options.requests_in_flight_max : 0;
  };
  int64_t count = std::max(window(stream_options_), static_cast<int32_t>(kept_.size()));
  if (successor_.has_value()) {
    count = std::max<int64_t>(count, window(successor_->options));
  }
  if (const int64_t bytes = count * AnswerBytesMax(); bytes < reserved_bytes_) {
    surroundings_.kept_answer_bytes->Change(reserved_bytes_, bytes);
    reserved_bytes_ = bytes;
  }
}

int64_t PoolSession::AnswerBytesMax() const {
  // An observation and a final one, which is not encoded, and what else a response of a single
  // environment has.
  constexpr int64_t kRowBytesMax = 512;
  if (shared_ring_ != nullptr) {
    return kRowBytesMax;  // the number of a batch
  }
  return env_count() * (coding_.sent_bytes_max() + coding_.drawn_bytes() + kRowBytesMax);
}

void PoolSession::BeginStream(const AttachOptions& options, EndStream end_stream) {
  attached_ = true;
  stream_options_ = options;
  end_stream_ = std::move(end_stream);
  expire_time_ = absl::InfiniteFuture();
  batches_.BeginStream(options.held_batches);
  if (!options.resumable) {
    kept_ = {};
    batches_.ForgetUpTo(next_sequence_number_);
  }
  TrimReservation();
}

void PoolSession::Detach() {
  EndStream last;  // destroyed outside the lock, as it may hold the stream
  std::optional<Successor> next;
  {
    absl::MutexLock lock(&mutex_);
    std::swap(last, end_stream_);
    std::swap(next, successor_);
    if (next.has_value()) {
      BeginStream(next->options, std::move(next->end_stream));
    } else {
      attached_ = false;
      stream_share_ = Owners::Share();
      BeginLease();
    }
  }
  if (next.has_value()) {
    next->done(absl::OkStatus());
  }
}

void PoolSession::BeginLease() {
  expire_time_ = surroundings_.lease_alarm->Now() + lease_duration_;
  surroundings_.lease_alarm->RingBy(expire_time_);
}

absl::Status PoolSession::Renew(std::optional<absl::Duration> lease_duration) {
  absl::MutexLock lock(&mutex_);
  if (!closed_.ok()) {
    return closed_;
  }
  lease_duration_ = lease_duration.value_or(lease_duration_);
  if (!attached_) {
    BeginLease();
  }
  return absl::OkStatus();
}

void PoolSession::End(StreamEnd why, const absl::Status& reason) {
  EndStream end_stream;
  {
    absl::MutexLock lock(&mutex_);
    std::swap(end_stream, end_stream_);
  }
  if (end_stream != nullptr) {
    end_stream(why, reason);
  }
}

void PoolSession::Close(const absl::Status& reason) {
  {
    absl::MutexLock lock(&mutex_);
    closed_ = reason;
  }
  pool_->Discard();
  TellClosed(reason);
}

void PoolSession::Fail(const absl::Status& reason) {
  {
    absl::MutexLock lock(&mutex_);
    if (!closed_.ok()) {
      return;
    }
    closed_ = reason;
  }
  TellClosed(reason);
}

bool PoolSession::CloseIfExpired(absl::Time now) {
  const absl::Status reason =
      absl::NotFoundError(absl::StrCat("there is no pool ", name_, " any more: its lease ran out"));
  {
    absl::MutexLock lock(&mutex_);
    if (expire_time_ > now) {
      return false;
    }
    closed_ = reason;
  }
  pool_->Discard();
  TellClosed(reason);
  return true;
}

void PoolSession::TellClosed(const absl::Status& reason) {
  std::deque<Done> waiting;
  std::optional<Successor> successor;
  {
    absl::MutexLock lock(&mutex_);
    waiting.swap(waiting_);
    successor.swap(successor_);
  }
  End(StreamEnd::kClosed, reason);
  EndTaps(reason);
  if (successor.has_value()) {
    successor->done(reason);
  }
  for (Done& begin : waiting) {
    begin(reason);
  }
}

void PoolSession::TakeTurn(Done begin) {
  absl::Status status;
  {
    absl::MutexLock lock(&mutex_);
    if (!closed_.ok()) {
      status = closed_;
    } else if (!turn_taken_) {
      turn_taken_ = true;
    } else if (waiting_.size() < kTurnsWaitingMax) {
      waiting_.push_back(std::move(begin));
      return;
    } else {
      status = absl::ResourceExhaustedError(absl::StrCat(waiting_.size(), " calls wait for pool ",
                                                         name_, ", allowed: ", kTurnsWaitingMax));
    }
  }
  begin(status);
}

void PoolSession::EndTurn() {
  Done begin;
  {
    absl::MutexLock lock(&mutex_);
    if (waiting_.empty()) {
      turn_taken_ = false;
      return;
    }
    begin = std::move(waiting_.front());
    waiting_.pop_front();
  }
  begin(absl::OkStatus());
}

absl::StatusOr<std::optional<Answer>> PoolSession::Accept(Request* request) {
  const int64_t expected = next_sequence_number_;
  const int64_t number = request->sequence_number;
  if (number < 1 || number > expected) {
    return absl::InvalidArgumentError(absl::StrCat(
        "sequence_number is ", number, ", allowed: ", expected, ", the next of pool ", name_));
  }
  if (request->acknowledged < 0 || request->acknowledged >= number) {
    return absl::InvalidArgumentError(absl::StrCat("acknowledged_sequence_number is ",
                                                   request->acknowledged, " with request ", number,
                                                   ", allowed: 0 to ", number - 1));
  }
  if (number < expected) {
    return Recall(*request);
  }
  if (absl::Status status = CheckRequest(name_, env_count(), request); !status.ok()) {
    return status;
  }
  if (absl::Status status = CheckNoneAwaitsReset(*request); !status.ok()) {
    return status;
  }
  {
    absl::MutexLock lock(&mutex_);
    if (absl::Status status = Take(request); !status.ok()) {
      return status;
    }
  }
  next_sequence_number_ = expected + 1;
  change_number_ += request->kind == Request::Kind::kObserve ? 0 : 1;
  return std::nullopt;
}

absl::StatusOr<Answer> PoolSession::Recall(const Request& request) {
  absl::MutexLock lock(&mutex_);
  const Answer* answer = kept_.Find(request.sequence_number);
  if (answer == nullptr) {
    return absl::FailedPreconditionError(
        absl::StrCat("sequence_number is ", request.sequence_number, ", which pool ", name_,
                     " has carried out before and whose answer is not kept; kept: ", kept_.Range(),
                     ", the next: ", int64_t{next_sequence_number_}));
  }
  Answer recalled = *answer;
  batches_.HoldAgain(request.sequence_number);
  batches_.ForgetUpTo(request.acknowledged);
  kept_.ForgetUpTo(request.acknowledged);
  TrimReservation();
  return recalled;
}

void PoolSession::Keep(int64_t sequence_number, Answer answer) {
  absl::MutexLock lock(&mutex_);
  kept_.Keep(sequence_number, std::move(answer));
}

absl::Status PoolSession::CheckNoneAwaitsReset(const Request& request) const {
  if (request.kind != Request::Kind::kStep || options().episode_end != EpisodeEnd::kDisabled) {
    return absl::OkStatus();
  }
  for (int32_t row = 0; row < request.count; ++row) {
    const int32_t environment = request.first + row;
    if (pool_->AwaitsReset(environment) &&
        std::none_of(request.resets.begin(), request.resets.end(),
                     [&](const Reset& reset) { return reset.environment == environment; })) {
      return absl::FailedPreconditionError(
          absl::StrCat("the episode of environment ", environment, " of pool ", name_,
                       " has ended; reset it before it is stepped"));
    }
  }
  return absl::OkStatus();
}

void PoolSession::RunPart(const Request& request, Part part, const Batch& batch, Done done,
                          NearEnd near_end) {
  if (part.first == request.first) {
    pool_->BeginRequest(request, batch);
  }
  done = OrTakeBack(request, std::move(done));
  if (request.kind == Request::Kind::kSample) {
    pool_->SetLevelSampler(request.level_sampler, std::move(done));
    return;
  }
  SelectPart(request.next_levels, part, &part_next_levels_);
  SelectPart(request.resets, part, &part_resets_);
  StepInput input;
  input.first = part.first;
  input.count = part.count;
  input.steps = request.kind == Request::Kind::kStep;
  if (input.steps) {
    input.actions = request.actions.subspan(static_cast<size_t>(part.first - request.first),
                                            static_cast<size_t>(part.count));
  }
  input.repeat = request.repeat;
  input.next_levels = part_next_levels_;
  input.resets = part_resets_;
  const Batch lent =
      request.kind == Request::Kind::kObserve ? batch : unasked_.LendTo(batch, part.count);
  pool_->StepAsync(
      input, lent,
      [this, &request, input, lent, done = std::move(done)](absl::Status status) mutable {
        Remember(request, input, lent, status.ok());
        TellTaps(request, {input.first, input.count}, lent, status.ok());
        done(std::move(status));
      },
      std::move(near_end));
}

void PoolSession::Remember(const Request& request, const StepInput& input, const Batch& batch,
                           bool ok) {
  if (request.kind == Request::Kind::kObserve) {
    return;
  }
  if (ok && input.steps) {
    *surroundings_.step_count += counts_.Add({input.first, input.count}, input.resets, batch);
  }
  if (episodes_ == nullptr) {
    return;
  }
  if (ok) {
    episodes_->Add(input, batch);
  } else if (input.first > request.first) {
    // Its earlier parts have not happened after all.
    episodes_->Lose({request.first, input.first - request.first}, EpisodeLack::kFailedRequest);
  }
}

PoolSession::Done PoolSession::OrTakeBack(const Request& request, Done done) {
  if (request.again || request.sequence_number <= 0) {
    return done;
  }
  return [this, number = request.sequence_number,
          done = std::move(done)](absl::Status status) mutable {
    if (!status.ok()) {
      next_sequence_number_ = number;
    }
    done(std::move(status));
  };
}

void PoolSession::ResumeAt(int64_t next_sequence_number) {
  if (episodes_ != nullptr && next_sequence_number > 1) {
    episodes_->Lose({0, env_count()}, EpisodeLack::kBeforeProcess);
  }
  next_sequence_number_ = next_sequence_number;
}

void PoolSession::Look(const std::vector<int32_t>& environments, View view, int32_t side_px,
                       HostedPool::LookDone done) {
  pool_->Look(environments, view, side_px, std::move(done));
}

}  // namespace procgen
