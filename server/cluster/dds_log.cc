#include "server/cluster/dds_log.h"

#include <cstdio>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "dds/dds.h"
#include "server/cluster/cluster.h"

namespace procgen {
namespace {

// The log of the process; Cyclone DDS has one for all domains.
class ProcessLog {
 public:
  static ProcessLog& Get() {
    static auto* const log = new ProcessLog;  // outlives all threads of Cyclone DDS
    return *log;
  }

  void SendTo(ClusterLog log) {
    absl::MutexLock lock(&mutex_);
    log_ = std::move(log);
  }

  void Report(bool is_error, absl::string_view message) {
    absl::MutexLock lock(&mutex_);
    if (is_error && collected_ != nullptr) {
      absl::StrAppend(collected_, collected_->empty() ? "" : "; ", message);
      return;
    }
    log_(is_error, message);
  }

  void Collect(std::string* complaints) {
    absl::MutexLock lock(&mutex_);
    mutex_.Await(absl::Condition(this, &ProcessLog::CollectsNothing));
    collected_ = complaints;
  }

  void EndToCollect() {
    absl::MutexLock lock(&mutex_);
    collected_ = nullptr;
  }

  std::string Copy(const std::string& complaints) const {
    absl::MutexLock lock(&mutex_);
    return complaints;
  }

 private:
  ProcessLog() { dds_set_log_sink(Sink, this); }

  static void Sink(void* log, const dds_log_data_t* line) {
    const absl::string_view message =
        absl::StripAsciiWhitespace(absl::string_view(line->message, line->size));
    const bool is_error = (line->priority & (DDS_LC_FATAL | DDS_LC_ERROR)) != 0;
    static_cast<ProcessLog*>(log)->Report(is_error, message);
  }

  bool CollectsNothing() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return collected_ == nullptr;
  }

  mutable absl::Mutex mutex_;
  ClusterLog log_ ABSL_GUARDED_BY(mutex_) = [](bool, absl::string_view message) {
    std::fprintf(stderr, "%s\n", std::string(message).c_str());
  };
  std::string* collected_ ABSL_GUARDED_BY(mutex_) = nullptr;
};

}  // namespace

void LogClusterTo(ClusterLog log) { ProcessLog::Get().SendTo(std::move(log)); }

void LogOfCluster(bool is_error, absl::string_view message) {
  ProcessLog::Get().Report(is_error, message);
}

DdsErrorLog::DdsErrorLog() { ProcessLog::Get().Collect(&text_); }
DdsErrorLog::~DdsErrorLog() { ProcessLog::Get().EndToCollect(); }
std::string DdsErrorLog::text() const { return ProcessLog::Get().Copy(text_); }

}  // namespace procgen
