#include "server/pool/request_executor.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/concurrency/deadline_timer.h"

namespace procgen {

RequestExecutor::RequestExecutor(Context context) : context_(std::move(context)) {}

void RequestExecutor::Execute(Request* request, std::shared_ptr<ResponseSink> sink) {
  context_.turns->Take([this, request, sink = std::move(sink)](const absl::Status& turn) mutable {
    if (!turn.ok()) {
      sink->Done(turn);
      return;
    }
    request_ = request;
    sink_ = std::move(sink);
    Begin();
  });
}

void RequestExecutor::Begin() {
  absl::Status status =
      CheckRequest(context_.pool_name, context_.pool->options().env_count, *request_);
  if (status.ok()) {
    status = CheckNoneAwaitsReset();
  }
  if (!status.ok()) {
    End(status);
    return;
  }
  begin_time_ = SteadyNow();
  if (request_->kind == Request::Kind::kSample) {
    context_.observers->AddChange();
    context_.executor->Run(context_.owner, [this] {
      OnExecuted(context_.pool->SetLevelSampler(request_->level_sampler));
    });
    return;
  }
  Step();
}

absl::Status RequestExecutor::CheckNoneAwaitsReset() const {
  const Request& request = *request_;
  if (request.kind != Request::Kind::kStep ||
      context_.pool->options().autoreset_mode != AutoresetMode::kDisabled) {
    return absl::OkStatus();
  }
  for (int32_t row = 0; row < request.count; ++row) {
    const int32_t environment = request.first + row;
    if (context_.pool->AwaitsReset(environment) &&
        std::none_of(request.resets.begin(), request.resets.end(),
                     [&](const Reset& reset) { return reset.environment == environment; })) {
      return absl::FailedPreconditionError(
          absl::StrCat("the episode of environment ", environment, " of pool ", context_.pool_name,
                       " has ended; reset it before it is stepped"));
    }
  }
  return absl::OkStatus();
}

void RequestExecutor::Step() {
  const Request& request = *request_;
  input_ = {.first = request.first,
            .count = request.count,
            .steps = request.kind == Request::Kind::kStep,
            .actions = request.actions,
            .repeat = request.repeat,
            .next_levels = request.next_levels,
            .resets = request.resets};
  batch_ = sink_->Prepare();
  final_scenes_.clear();
  if (request.kind != Request::Kind::kObserve) {
    context_.observers->AddChange();
    batch_ = unasked_.ReplaceEmptyArrays(batch_, request.count);
  }
  if (input_.steps) {
    context_.observers->SelectFinalScenes(request.first, request.count, &final_scenes_);
  }
  batch_.final_scenes = absl::MakeSpan(final_scenes_);
  context_.pool->StepAsync(input_, batch_, [this](const absl::Status& status) {
    if (status.ok()) {
      context_.observers->OnExecuted(*request_, input_, batch_, request_count_ + 1);
    } else {
      context_.observers->OnInvalidated();
    }
    OnExecuted(status);
  });
}

void RequestExecutor::OnExecuted(const absl::Status& status) {
  if (status.ok()) {
    ++request_count_;
    const absl::Time now = SteadyNow();
    context_.metrics->AddRequest(begin_time_ - request_->arrival_time, now - begin_time_);
    request_times_.Add(now - request_->arrival_time);
  }
  End(status);
}

void RequestExecutor::End(const absl::Status& status) {
  // Copies: the next request may begin in Done, or another caller's turn here.
  const absl::Status ended = status;  // NOLINT(performance-unnecessary-copy-initialization)
  const std::shared_ptr<ResponseSink> sink = std::move(sink_);
  context_.turns->End();
  sink->Done(ended);
}

}  // namespace procgen
