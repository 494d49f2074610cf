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

PoolSession::PoolSession(std::string owner, std::string name, std::unique_ptr<Pool> pool,
                         absl::Time create_time, Owners* owners, SideCrew* side_crew,
                         std::atomic<int64_t>* step_count)
    : owner_(std::move(owner)),
      name_(std::move(name)),
      pool_(std::move(pool)),
      create_time_(create_time),
      owners_(owners),
      side_crew_(side_crew),
      step_count_(step_count) {}

PoolSession::~PoolSession() = default;

bool PoolSession::attached() const {
  absl::MutexLock lock(&mutex_);
  return attached_;
}

absl::Status PoolSession::Attach(EndStream end_stream) {
  absl::MutexLock lock(&mutex_);
  if (!closed_.ok()) {
    return closed_;
  }
  if (attached_) {
    return absl::FailedPreconditionError(absl::StrCat("another stream is attached to pool ", name_,
                                                      ", allowed: one at a time; end that one"));
  }
  absl::StatusOr<Owners::Share> share = owners_->Take(owner_, {.stream_count = 1});
  if (!share.ok()) {
    return share.status();
  }
  attached_ = true;
  stream_share_ = *std::move(share);
  end_stream_ = std::move(end_stream);
  return absl::OkStatus();
}

void PoolSession::Detach() {
  EndStream last;  // destroyed outside the lock, as it may hold the stream
  absl::MutexLock lock(&mutex_);
  attached_ = false;
  stream_share_ = Owners::Share();
  std::swap(last, end_stream_);
}

void PoolSession::End(const absl::Status& reason) {
  EndStream end_stream;
  {
    absl::MutexLock lock(&mutex_);
    std::swap(end_stream, end_stream_);
  }
  if (end_stream != nullptr) {
    end_stream(reason);
  }
}

void PoolSession::Close(const absl::Status& reason) {
  std::deque<Done> waiting;
  {
    absl::MutexLock lock(&mutex_);
    closed_ = reason;
    waiting.swap(waiting_);
  }
  End(reason);
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

absl::Status PoolSession::Accept(Request* request) {
  const int64_t expected = next_sequence_number_;
  if (request->sequence_number >= 1 && request->sequence_number < expected) {
    return absl::UnimplementedError(
        absl::StrCat("sequence_number is ", request->sequence_number, ", which pool ", name_,
                     " has carried out before, and answers are not kept yet; allowed: ", expected));
  }
  if (request->sequence_number != expected) {
    return absl::InvalidArgumentError(absl::StrCat("sequence_number is ", request->sequence_number,
                                                   ", allowed: ", expected, ", the next of pool ",
                                                   name_));
  }
  if (absl::Status status = CheckRequest(name_, env_count(), request); !status.ok()) {
    return status;
  }
  if (absl::Status status = CheckNoneAwaitsReset(*request); !status.ok()) {
    return status;
  }
  next_sequence_number_ = expected + 1;
  change_number_ += request->kind == Request::Kind::kObserve ? 0 : 1;
  return absl::OkStatus();
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

void PoolSession::RunPart(const Request& request, Part part, const Batch& batch, Done done) {
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
  pool_->StepAsync(input, batch,
                   [this, stepped = input.steps ? part.count : 0,
                    done = std::move(done)](absl::Status status) mutable {
                     *step_count_ += status.ok() ? stepped : 0;
                     done(std::move(status));
                   });
}

void PoolSession::SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) {
  side_crew_->Run([this, environments, take = std::move(take), done = std::move(done)]() mutable {
    absl::Status status;
    for (const int32_t environment : environments) {
      absl::StatusOr<std::vector<std::string>> snapshots = pool_->SaveStates({environment});
      status = snapshots.status();
      if (!status.ok() || !take(environment, std::move(snapshots->front()))) {
        break;
      }
    }
    done(std::move(status));
  });
}

void PoolSession::RestoreStates(std::vector<StateToRestore> states, Done done) {
  ++change_number_;
  side_crew_->Run([this, states = std::move(states), done = std::move(done)]() mutable {
    done(pool_->RestoreStates(states));
  });
}

void PoolSession::CloneStates(std::vector<StateToClone> pairs, Done done) {
  ++change_number_;
  side_crew_->Run([this, pairs = std::move(pairs), done = std::move(done)]() mutable {
    done(pool_->CloneStates(pairs));
  });
}

void PoolSession::Render(absl::Span<const int32_t> environments, int32_t side_px,
                         std::vector<absl::Span<uint8_t>> frames, Done done) {
  side_crew_->Run(
      [this, environments, side_px, frames = std::move(frames), done = std::move(done)]() mutable {
        absl::Status status;
        for (size_t i = 0; i < environments.size() && status.ok(); ++i) {
          status = pool_->Render(environments[i], side_px, frames[i]);
        }
        done(std::move(status));
      });
}

}  // namespace procgen
