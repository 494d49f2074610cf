#include "server/fleet/log/pool_log.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace procgen {

PoolLog::PoolLog(int32_t env_count, int32_t frame_stack, std::string label, int64_t bytes_max)
    : label_(std::move(label)),
      frame_stack_(frame_stack),
      bytes_max_(bytes_max),
      requests_(env_count, frame_stack) {}

absl::Status PoolLog::Keep(const std::string& path, JournaledPool pool, Metrics* metrics) {
  auto journal = Journal::Create(path, std::move(pool), metrics);
  if (!journal.ok()) {
    return journal.status();
  }
  journal_ = *std::move(journal);
  return absl::OkStatus();
}

void PoolLog::Resume(const std::string& path, const JournaledPool& pool, Metrics* metrics) {
  journal_ = Journal::Resume(path, pool, metrics);
  requests_.BeginAfter(pool.log_begin);
  for (const RequestLog::Entry& entry : pool.log) {
    requests_.Append(entry);
  }
}

absl::Status PoolLog::CheckRoom(bool may_shorten) const {
  const int64_t bytes = requests_.BytesAfter(0);
  if (bytes < bytes_max_ || (may_shorten && bytes < bytes_max_ + bytes_max_ / 8)) {
    return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(absl::StrCat(
      "the log of ", label_, " has ", bytes, " bytes, limit log_bytes_max: ", bytes_max_,
      "; it shrinks once each environment has been stepped ", std::max(frame_stack_, 1),
      " times and its state can be saved: step all environments, or create another pool"));
}

int64_t PoolLog::Append(LoggedRequest logged) {
  auto entry = std::make_shared<const LoggedRequest>(std::move(logged));
  if (journal_ != nullptr) {
    journal_->Append(entry);
  }
  return requests_.Append(std::move(entry));
}

void PoolLog::RemoveLast() {
  if (journal_ != nullptr) {
    journal_->RemoveLast();
  }
  requests_.RemoveLast();
}

void PoolLog::SetCheckpoint(Part range, std::shared_ptr<const ShardCheckpoint> checkpoint) {
  if (journal_ != nullptr) {
    journal_->SetCheckpoint(range, std::move(checkpoint));
  }
}

void PoolLog::SetCheckpoints(ShardCheckpoints checkpoints) {
  if (journal_ != nullptr) {
    journal_->SetCheckpoints(std::move(checkpoints));
  }
}

void PoolLog::Discard() {
  if (journal_ != nullptr) {
    journal_->Remove();
  }
}

}  // namespace procgen
