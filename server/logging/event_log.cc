#include "server/logging/event_log.h"

#include <unistd.h>

#include <memory>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/concurrency/steady_time.h"
#include "spdlog/async_logger.h"
#include "spdlog/details/null_mutex.h"
#include "spdlog/details/thread_pool.h"
#include "spdlog/sinks/base_sink.h"
#include "spdlog/spdlog.h"

namespace procgen {
namespace {

// Writes without stdio, whose locks a blocked write would hold while the process exits.
class StandardErrorSink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
  void sink_it_(const spdlog::details::log_msg& line) override {
    spdlog::memory_buf_t text;
    formatter_->format(line, text);
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
  }
  void flush_() override {}
};

struct Log {
  std::shared_ptr<spdlog::details::thread_pool> thread =
      std::make_shared<spdlog::details::thread_pool>(kLogLinesMax, /*threads_n=*/1);
  std::shared_ptr<spdlog::logger> logger = std::make_shared<spdlog::async_logger>(
      "procgen-server", std::make_shared<StandardErrorSink>(), thread,
      spdlog::async_overflow_policy::overrun_oldest);
};

Log* MakeLog() {
  auto* const log = new Log;
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
  // The log's thread takes this from its queue when the lines before it are written.
  log.logger->flush();
  const absl::Time end = SteadyNow() + timeout;
  while (log.thread->queue_size() > 0 && SteadyNow() < end) {
    absl::SleepFor(absl::Milliseconds(1));
  }
}

void SetLogLevel(LogLevel level) { TheLog().logger->set_level(SpdlogLevel(level)); }

}  // namespace procgen
