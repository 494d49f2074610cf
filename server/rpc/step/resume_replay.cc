#include "server/rpc/step/resume_replay.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "grpc/support/time.h"
#include "grpcpp/alarm.h"
#include "server/logging/event_log.h"
#include "server/rpc/step/response.h"
#include "server/rpc/step/response_builder.h"
#include "server/session/pool/pool_observer.h"
#include "server/session/pool/response_sink.h"
#include "server/session/quota/limits.h"
#include "server/wire/convert_step.h"

namespace procgen {
namespace {

// Delay between attempts. It doubles after each failure and is reset by a success.
constexpr absl::Duration kBackoffMin = absl::Milliseconds(100);
constexpr absl::Duration kBackoffMax = absl::Seconds(5);

// Whether a retry would fail in the same way.
bool IsPermanent(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kOutOfRange:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kDataLoss:
      return true;
    default:
      return false;
  }
}

// Returns the time after `duration` on the steady clock.
gpr_timespec After(absl::Duration duration) {
  return gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC),
                      gpr_time_from_millis(absl::ToInt64Milliseconds(duration), GPR_TIMESPAN));
}

// Shared, because it lives until its last callback. It observes the pool to detect its end and a
// drain.
class ResumeReplay final : public PoolObserver,
                           public ResponseSink,
                           public std::enable_shared_from_this<ResumeReplay> {
 public:
  ResumeReplay(std::shared_ptr<PoolSession> pool, std::vector<std::string> requests,
               int64_t response_bytes_max)
      : pool_(std::move(pool)),
        requests_(std::move(requests)),
        response_bytes_max_(response_bytes_max) {
    // A final observe reads the state of all environments.
    v1::StepPoolRequest observe;
    observe.mutable_observe()->set_observation(v1::OBSERVATION_NONE);
    observe.mutable_observe()->mutable_slice()->set_env_count(pool_->env_count());
    requests_.push_back(observe.SerializeAsString());
  }

  void Start() {
    pool_->TakeTurn([self = shared_from_this()](const absl::Status& turn) {
      if (turn.ok() && self->pool_->AddObserver(self).ok()) {
        self->ExecuteNext();
      } else if (turn.ok()) {
        self->pool_->EndTurn();
      }
    });
  }

  void OnPart(const Request& /*request*/, const StepInput& /*input*/,
              const Batch& /*batch*/) override {}
  void OnRequestEnd(int64_t /*sequence_number*/, int64_t /*change_number*/) override {}
  void OnInvalidated() override {}
  void OnEnd(const absl::Status& /*reason*/) override {
    std::shared_ptr<grpc::Alarm> alarm;
    {
      absl::MutexLock lock(&mutex_);
      ended_ = true;
      alarm = alarm_;
    }
    if (alarm != nullptr) {
      alarm->Cancel();
    }
  }

  absl::StatusOr<std::optional<Batch>> PreparePart(Part part) override {
    return request_.request.again ? builder_.Prepare(*pool_, request_.request, part, &response_)
                                  : Batch();
  }
  absl::Cord PartDone(Part /*part*/, bool keep) override {
    grpc::ByteBuffer bytes;
    return keep ? builder_.Complete(*pool_, request_.request, keep, &response_, &bytes)
                : absl::Cord();
  }
  absl::Status Recall(const Answer& /*answer*/) override {
    return absl::InternalError("a request of an earlier process was executed by this one");
  }
  void Done(const absl::Status& status) override {
    builder_.ResetEncoder();
    if (!status.ok()) {
      Fail(status);
      return;
    }
    backoff_ = kBackoffMin;
    ++next_;
    ExecuteNext();
  }

 private:
  // Executes the next valid request; ends the turn if none is left.
  void ExecuteNext() {
    for (; next_ < requests_.size(); ++next_) {
      const absl::Status status = Read();
      if (status.ok()) {
        pool_->ExecuteInTurn(&request_.request, shared_from_this());
        return;
      }
      LogEvent(LogLevel::kWarning, "request_replay_skipped", EventOf(status));
    }
    End();
  }

  absl::Status Read() {
    const bool is_observe = next_ + 1 == requests_.size();
    absl::Status status = request_.message.ParseFromString(requests_[next_])
                              ? ReadStreamRequest(&request_)
                              : absl::InternalError("invalid StepPoolRequest");
    if (status.ok()) {
      status = SetRowsMax();
    }
    request_.request.again = !is_observe;
    return status;
  }

  absl::Status SetRowsMax() {
    for (const int64_t bytes : {int64_t{kMessageBytesMin}, response_bytes_max_}) {
      const auto rows =
          ResponseRowsMax("response_bytes_max", request_.request, pool_->coding(), bytes);
      if (rows.ok() || bytes == response_bytes_max_) {
        request_.request.chunk_rows_max = rows.value_or(0);
        return rows.status();
      }
    }
    return absl::OkStatus();
  }

  void Fail(const absl::Status& status) {
    if (IsPermanent(status)) {
      LogEvent(LogLevel::kError, "pool_resume_failed", EventOf(status));
      pool_->Fail({status.code(), absl::StrCat("pool ", pool_->name(),
                                               " could not be resumed: ", status.message())});
      End();
      return;
    }
    // For example, nodes of the fleet may still be starting. The turn is kept, so that all other
    // callers wait for the replay.
    LogEvent(LogLevel::kWarning, "pool_resume_delayed", EventOf(status));
    {
      absl::MutexLock lock(&mutex_);
      if (!ended_) {
        alarm_ = std::make_shared<grpc::Alarm>();
        alarm_->Set(After(std::exchange(backoff_, std::min(2 * backoff_, kBackoffMax))),
                    [self = shared_from_this()](bool /*is_due*/) { self->OnAlarm(); });
        return;
      }
    }
    End();
  }

  void OnAlarm() {
    bool ended = false;
    {
      absl::MutexLock lock(&mutex_);
      alarm_ = nullptr;  // its callback has a reference to this object
      ended = ended_;
    }
    if (ended) {
      End();
    } else {
      ExecuteNext();
    }
  }

  void End() {
    pool_->RemoveObserver(this);
    pool_->EndTurn();
  }

  EventFields EventOf(const absl::Status& status) const {
    return {{"pool", pool_->name()},
            {"owner", pool_->owner()},
            {"message", std::string(status.message())}};
  }

  const std::shared_ptr<PoolSession> pool_;
  std::vector<std::string> requests_;
  const int64_t response_bytes_max_;
  size_t next_ = 0;  // index of the current request
  StreamRequest request_;
  ResponseBuilder builder_;
  Response response_;
  absl::Duration backoff_ = kBackoffMin;

  absl::Mutex mutex_;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;  // the pool is closed, or the server drains
  // Set between attempts. Shared, because OnEnd cancels it outside of the lock.
  std::shared_ptr<grpc::Alarm> alarm_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

void StartResumeReplay(std::shared_ptr<PoolSession> pool, std::vector<std::string> requests,
                       int64_t response_bytes_max) {
  std::make_shared<ResumeReplay>(std::move(pool), std::move(requests), response_bytes_max)->Start();
}

}  // namespace procgen
