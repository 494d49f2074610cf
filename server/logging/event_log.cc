#include "server/logging/event_log.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <system_error>

#include "absl/base/thread_annotations.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "server/concurrency/steady_time.h"
#include "spdlog/async_logger.h"
#include "spdlog/details/thread_pool.h"
#include "spdlog/sinks/base_sink.h"
#include "spdlog/spdlog.h"

namespace procgen {
namespace {

// Writes to standard error, only on the log's thread. Lines that cannot be written are lost.
class StandardErrorSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  // Sets the function that returns the number of lines dropped since the start. REQUIRES: called
  // before the first line.
  void CountDropped(std::function<size_t()> dropped) { dropped_ = std::move(dropped); }

  // Number of flushes since the start.
  int64_t flush_count() const {
    absl::MutexLock lock(&flush_mutex_);
    return flush_count_;
  }
  void AwaitFlush(int64_t count, absl::Duration timeout) {
    absl::MutexLock lock(&flush_mutex_);
    flushed_.AwaitUntil(&flush_mutex_, SteadyNow() + timeout,
                        [&]() ABSL_NO_THREAD_SAFETY_ANALYSIS { return flush_count_ >= count; });
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& line) override {
    if (const size_t dropped = dropped_(); dropped > reported_dropped_) {
      const std::string text =
          absl::StrCat("event=log_lines_dropped count=", dropped - reported_dropped_);
      reported_dropped_ = dropped;
      spdlog::details::log_msg report = line;
      report.level = spdlog::level::warn;
      report.payload = spdlog::string_view_t(text.data(), text.size());
      Write(report);
    }
    Write(line);
  }

  void flush_() override {
    absl::MutexLock lock(&flush_mutex_);
    ++flush_count_;
    flushed_.NotifyAll();
  }

 private:
  void Write(const spdlog::details::log_msg& line) {
    spdlog::memory_buf_t text;
    formatter_->format(line, text);
    for (size_t begin = 0; begin < text.size();) {
      const ssize_t written = write(STDERR_FILENO, text.data() + begin, text.size() - begin);
      if (written < 0 && errno != EINTR) {
        return;
      }
      begin += static_cast<size_t>(std::max<ssize_t>(0, written));
    }
  }

  std::function<size_t()> dropped_ = [] { return size_t{0}; };
  size_t reported_dropped_ = 0;  // used only by the log's thread
  mutable absl::Mutex flush_mutex_;
  SteadyCondVar flushed_;
  int64_t flush_count_ ABSL_GUARDED_BY(flush_mutex_) = 0;
};

struct Log {
  std::shared_ptr<StandardErrorSink> sink = std::make_shared<StandardErrorSink>();
  std::shared_ptr<spdlog::details::thread_pool> thread;  // null: it could not be started
  std::shared_ptr<spdlog::logger> logger;
};

Log* MakeLog() {
  auto* const log = new Log;
  try {
    log->thread = std::make_shared<spdlog::details::thread_pool>(kLogLinesMax, /*threads_n=*/1);
    log->logger = std::make_shared<spdlog::async_logger>(
        "procgen-server", log->sink, log->thread, spdlog::async_overflow_policy::overrun_oldest);
    log->sink->CountDropped([log] { return log->thread->overrun_counter(); });
  } catch (const std::system_error&) {
    // No thread can be started, so the process will exit soon. Log synchronously to report it.
    log->logger = std::make_shared<spdlog::logger>("procgen-server", log->sink);
  }
  log->logger->set_pattern("time=%Y-%m-%dT%H:%M:%S.%eZ level=%l %v",
                           spdlog::pattern_time_type::utc);
  return log;
}

Log& TheLog() {
  // Never destroyed: threads may log until the process ends.
  static Log* const log = MakeLog();
  return *log;
}

spdlog::level::level_enum SpdlogLevel(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
  }
  return spdlog::level::info;
}

}  // namespace

void LogEvent(LogLevel level, absl::string_view event, const EventFields& fields) {
  spdlog::logger& logger = *TheLog().logger;
  if (!logger.should_log(SpdlogLevel(level))) {
    return;
  }
  std::string line = absl::StrCat("event=", event);
  for (const auto& [key, value] : fields) {
    const bool plain = !value.empty() && value.find_first_of(" \"=\\") == std::string::npos &&
                       value == absl::CEscape(value);
    absl::StrAppend(&line, " ", key, "=");
    if (plain) {
      line += value;
    } else {
      absl::StrAppend(&line, "\"", absl::CEscape(value), "\"");
    }
  }
  logger.log(SpdlogLevel(level), spdlog::string_view_t(line.data(), line.size()));
}

void FlushLog(absl::Duration timeout) {
  Log& log = TheLog();
  const int64_t count = log.sink->flush_count() + 1;
  log.logger->flush();
  log.sink->AwaitFlush(count, timeout);
}

void SetLogLevel(LogLevel level) { TheLog().logger->set_level(SpdlogLevel(level)); }

}  // namespace procgen
