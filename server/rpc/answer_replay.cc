#include "server/rpc/answer_replay.h"

#include <cstddef>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "server/rpc/convert_step.h"
#include "server/rpc/running_request.h"
#include "server/session/event_log.h"
#include "server/session/limits.h"

namespace procgen {
namespace {

// Shared, because it lasts until its last callback.
class AnswerReplay final : public std::enable_shared_from_this<AnswerReplay> {
 public:
  AnswerReplay(std::shared_ptr<PoolSession> pool, std::vector<std::string> requests,
               int64_t response_bytes_max)
      : pool_(std::move(pool)),
        requests_(std::move(requests)),
        response_bytes_max_(response_bytes_max) {
    // The last one tells how all environments stand, and that they are where they were.
    v1::StepPoolRequest look;
    look.mutable_observe()->set_observation(v1::OBSERVATION_NONE);
    look.mutable_observe()->mutable_slice()->set_environment_count(pool_->env_count());
    requests_.push_back(look.SerializeAsString());
  }

  void Start() {
    pool_->TakeTurn([self = shared_from_this()](const absl::Status& turn) {
      if (turn.ok()) {
        self->RunNext();
      }
    });
  }

 private:
  void RunNext() {
    if (next_ == requests_.size()) {
      pool_->EndTurn();
      return;
    }
    const bool is_look = next_ + 1 == requests_.size();
    absl::Status status = request_.message.ParseFromString(requests_[next_])
                              ? ReadStreamRequest(&request_)
                              : absl::InternalError("it is no request");
    if (status.ok()) {
      status = SetRowsMax();
    }
    if (!status.ok()) {
      Skip(status);
      return;
    }
    request_.request.again = !is_look;
    keeps_ = !is_look;
    running_ = std::make_unique<RunningRequest>();
    running_->Begin(&request_);
    RunPart();
  }

  absl::Status SetRowsMax() {
    for (const int64_t bytes : {int64_t{kMessageBytesMin}, response_bytes_max_}) {
      const auto rows = ResponseRowsMax("response_bytes_max", request_, pool_->coding(), bytes);
      if (rows.ok() || bytes == response_bytes_max_) {
        request_.rows_max = rows.value_or(0);
        return rows.status();
      }
    }
    return absl::OkStatus();
  }

  void RunPart() {
    running_->RunPart(
        pool_.get(), keeps_ ? &response_ : nullptr,
        [self = shared_from_this()](const absl::Status& status) { self->OnPartDone(status); });
  }

  void OnPartDone(const absl::Status& status) {
    running_->EndPart(*pool_, status.ok(), keeps_);
    if (!status.ok()) {
      Fail(status);
      return;
    }
    if (!running_->IsOver()) {
      RunPart();
      return;
    }
    if (keeps_) {
      pool_->Keep(running_->sequence_number(), running_->TakeAnswer());
    }
    ++next_;
    RunNext();
  }

  // Nodes have not come in time; they may yet. The turn stays: what others want comes after.
  void Fail(const absl::Status& status) {
    LogEvent(LogLevel::kWarning, "pool_waits",
             {{"pool", pool_->name()},
              {"owner", pool_->owner()},
              {"message", std::string(status.message())}});
    if (pool_->closed()) {
      pool_->EndTurn();
    } else {
      RunNext();
    }
  }

  void Skip(const absl::Status& status) {
    LogEvent(LogLevel::kWarning, "answer_not_kept",
             {{"pool", pool_->name()},
              {"owner", pool_->owner()},
              {"message", std::string(status.message())}});
    ++next_;
    RunNext();
  }

  const std::shared_ptr<PoolSession> pool_;
  std::vector<std::string> requests_;
  const int64_t response_bytes_max_;
  size_t next_ = 0;
  bool keeps_ = false;
  StreamRequest request_;
  Response response_;
  std::unique_ptr<RunningRequest> running_;
};

}  // namespace

void ReplayAnswers(std::shared_ptr<PoolSession> pool, std::vector<std::string> requests,
                   int64_t response_bytes_max) {
  std::make_shared<AnswerReplay>(std::move(pool), std::move(requests), response_bytes_max)->Start();
}

}  // namespace procgen
