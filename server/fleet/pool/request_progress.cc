#include "server/fleet/pool/request_progress.h"

#include <algorithm>
#include <utility>

#include "server/fleet/log/shard_request.h"

namespace procgen {

void RequestProgress::Begin(Part slice) {
  absl::MutexLock lock(&mutex_);
  slice_ = slice;
  has_started_ = false;
  status_ = absl::OkStatus();
}

void RequestProgress::Start(std::vector<Part> ranges, absl::Status status) {
  absl::MutexLock lock(&mutex_);
  has_started_ = true;
  running_ = std::move(ranges);
  status_ = std::move(status);
}

std::optional<RequestProgress::Answer> RequestProgress::AddPart(Part part, const Batch& batch,
                                                                PoolBackend::Done done) {
  absl::MutexLock lock(&mutex_);
  part_ = part;
  batch_ = batch;
  done_ = std::move(done);
  return TakeAnswer();
}

std::optional<RequestProgress::Answer> RequestProgress::OnShardDone(Part range,
                                                                    const absl::Status& status) {
  absl::MutexLock lock(&mutex_);
  std::erase_if(running_, [range](const Part& each) { return each.first == range.first; });
  status_.Update(status);
  return TakeAnswer();
}

std::optional<RequestProgress::Answer> RequestProgress::TakeAnswer() {
  if (done_ == nullptr || !has_started_) {
    return std::nullopt;
  }
  const bool is_last = part_.first + part_.count == slice_.first + slice_.count;
  const bool needs_all = is_last || !status_.ok();
  const bool waits =
      std::any_of(running_.begin(), running_.end(), [needs_all, part = part_](const Part& range) {
        return needs_all || Overlap(part, range).count > 0;
      });
  if (waits) {
    return std::nullopt;
  }
  return Answer{part_, batch_, std::exchange(done_, nullptr), status_};
}

}  // namespace procgen
