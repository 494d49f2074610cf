#include "server/session/pool/request_executor.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/concurrency/deadline_timer.h"

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

// REQUIRES: number > 0.
int32_t QuotientUp(int32_t number, int32_t divisor) { return (number - 1) / divisor + 1; }

}  // namespace

RequestExecutor::RequestExecutor(Context context) : context_(std::move(context)) {}

void RequestExecutor::Execute(Request* request, std::shared_ptr<ResponseSink> sink) {
  context_.turns->Take([this, request, sink = std::move(sink)](const absl::Status& turn) mutable {
    if (!turn.ok()) {
      sink->Done(turn);
      return;
    }
    of_stream_ = true;
    request_ = request;
    sink_ = std::move(sink);
    state_ = State::kBegin;
    Advance();
  });
}

void RequestExecutor::ExecuteInTurn(Request* request, std::shared_ptr<ResponseSink> sink) {
  of_stream_ = false;
  request_ = request;
  sink_ = std::move(sink);
  state_ = State::kBegin;
  Advance();
}

void RequestExecutor::Advance() {
  if (advances_due_++ > 0) {
    return;
  }
  std::shared_ptr<ResponseSink> sink;
  do {
    if (sink_ != nullptr) {
      sink = sink_;
    }
    if (!Step()) {
      return;
    }
  } while (--advances_due_ > 0);
  sink->Flush();
}

bool RequestExecutor::Step() {
  switch (state_) {
    case State::kBegin:
      return Begin();
    case State::kPrepare:
      return Prepare();
    case State::kRunning:
      return true;
    case State::kPartRan:
      return EndPart();
  }
  return true;
}

bool RequestExecutor::Begin() {
  answer_.clear();
  if (!sink_->IsWanted()) {
    return End(absl::CancelledError());
  }
  const absl::StatusOr<std::optional<Answer>> accepted = Accept(request_);
  if (!accepted.ok()) {
    return End(accepted.status());
  }
  if (accepted->has_value()) {
    return End(sink_->Recall(**accepted));
  }
  begin_time_ = SteadyNow();
  arrival_time_ = request_->arrival_time;
  sequence_number_ = request_->sequence_number;
  rest_ = request_->count;
  part_ = {request_->first, 0};
  parts_left_ = rest_ == 0 ? 0
                           : std::max(std::min(request_->chunk_count, rest_),
                                      QuotientUp(rest_, request_->chunk_rows_max));
  SelectNextPart();
  return Prepare();
}

absl::StatusOr<std::optional<Answer>> RequestExecutor::Accept(Request* request) {
  if (!of_stream_) {
    keeps_ = request->again;
    if (absl::Status status =
            CheckRequest(context_.pool_name, context_.backend->env_count(), request);
        !status.ok()) {
      return status;
    }
    return std::nullopt;
  }
  const int64_t expected = next_sequence_number_;
  const int64_t number = request->sequence_number;
  if (number < 1 || number > expected) {
    return absl::InvalidArgumentError(absl::StrCat("sequence_number is ", number,
                                                   ", allowed: ", expected, ", the next of pool ",
                                                   context_.pool_name));
  }
  if (request->acknowledged < 0 || request->acknowledged >= number) {
    return absl::InvalidArgumentError(absl::StrCat("acknowledged_sequence_number is ",
                                                   request->acknowledged, " with request ", number,
                                                   ", allowed: 0 to ", number - 1));
  }
  if (number < expected) {
    return context_.resume_buffer->Recall(*request, expected);
  }
  if (absl::Status status =
          CheckRequest(context_.pool_name, context_.backend->env_count(), request);
      !status.ok()) {
    return status;
  }
  if (absl::Status status = CheckNoneAwaitsReset(*request); !status.ok()) {
    return status;
  }
  const absl::StatusOr<bool> keeps = context_.resume_buffer->Take(request);
  if (!keeps.ok()) {
    return keeps.status();
  }
  keeps_ = *keeps;
  next_sequence_number_ = expected + 1;
  if (request->kind != Request::Kind::kObserve) {
    context_.observers->AddChange();
  }
  return std::nullopt;
}

absl::Status RequestExecutor::CheckNoneAwaitsReset(const Request& request) const {
  if (request.kind != Request::Kind::kStep ||
      context_.backend->options().autoreset_mode != AutoresetMode::kDisabled) {
    return absl::OkStatus();
  }
  for (int32_t row = 0; row < request.count; ++row) {
    const int32_t environment = request.first + row;
    if (context_.backend->AwaitsReset(environment) &&
        std::none_of(request.resets.begin(), request.resets.end(),
                     [&](const Reset& reset) { return reset.environment == environment; })) {
      return absl::FailedPreconditionError(
          absl::StrCat("the episode of environment ", environment, " of pool ", context_.pool_name,
                       " has ended; reset it before it is stepped"));
    }
  }
  return absl::OkStatus();
}

void RequestExecutor::SelectNextPart() {
  part_.first += part_.count;
  part_.count = rest_ == 0 ? 0 : QuotientUp(rest_, parts_left_);
  --parts_left_;
}

bool RequestExecutor::Prepare() {
  state_ = State::kPrepare;
  absl::StatusOr<std::optional<Batch>> batch = sink_->PreparePart(part_);
  if (!batch.ok()) {
    return End(batch.status());
  }
  if (batch->has_value()) {
    batch_ = **batch;
    RunPart();
  }
  return true;
}

void RequestExecutor::RunPart() {
  state_ = State::kRunning;
  PoolBackend* const backend = context_.backend;
  const Request& request = *request_;
  if (part_.first == request.first) {
    backend->BeginRequest(request, batch_);
  }
  auto done = [this](absl::Status status) {
    if (request_->kind != Request::Kind::kSample) {
      context_.observers->OnPart(*request_, input_, batch_, status.ok());
    }
    part_status_ = std::move(status);
    state_ = State::kPartRan;
    Advance();
  };
  if (request.kind == Request::Kind::kSample) {
    backend->SetLevelSampler(request.level_sampler, std::move(done));
    return;
  }
  SelectPart(request.next_levels, part_, &part_next_levels_);
  SelectPart(request.resets, part_, &part_resets_);
  input_ = StepInput();
  input_.first = part_.first;
  input_.count = part_.count;
  input_.steps = request.kind == Request::Kind::kStep;
  if (input_.steps) {
    input_.actions = request.actions.subspan(static_cast<size_t>(part_.first - request.first),
                                             static_cast<size_t>(part_.count));
  }
  input_.repeat = request.repeat;
  input_.next_levels = part_next_levels_;
  input_.resets = part_resets_;
  if (request.kind != Request::Kind::kObserve) {
    batch_ = unasked_.ReplaceEmptyArrays(batch_, part_.count);
  }
  final_scenes_.clear();
  if (input_.steps) {
    context_.observers->SelectFinalScenes(part_, &final_scenes_);
  }
  batch_.final_scenes = absl::MakeSpan(final_scenes_);
  backend->StepAsync(input_, batch_, std::move(done));
}

bool RequestExecutor::EndPart() {
  if (!part_status_.ok()) {
    if (of_stream_) {
      next_sequence_number_ = sequence_number_;
    }
    return End(part_status_);
  }
  rest_ -= part_.count;
  absl::Cord kept = sink_->PartDone(part_, keeps_);
  if (keeps_) {
    answer_.push_back(std::move(kept));
  }
  if (rest_ > 0) {
    SelectNextPart();
    return Prepare();
  }
  // From here on the request may be destroyed: its answer may have been sent.
  if (keeps_) {
    context_.resume_buffer->Keep(sequence_number_, std::exchange(answer_, {}));
  }
  if (of_stream_) {
    const absl::Time now = SteadyNow();
    context_.metrics->AddRequest(begin_time_ - arrival_time_, now - begin_time_);
    request_times_.Add(now - arrival_time_);
  }
  return End(absl::OkStatus());
}

bool RequestExecutor::End(const absl::Status& status) {
  // A copy: the next request, which begins here, may set what `status` refers to.
  const absl::Status ended = status;  // NOLINT(performance-unnecessary-copy-initialization)
  const std::shared_ptr<ResponseSink> sink = std::move(sink_);
  if (!of_stream_) {
    sink->Done(ended);  // may begin the next request, for which Advance is due then
    return true;
  }
  advances_due_ = 0;
  context_.turns->End();
  sink->Done(ended);
  return false;
}

}  // namespace procgen
