#ifndef SERVER_LOGGING_EVENT_LOG_H_
#define SERVER_LOGGING_EVENT_LOG_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace procgen {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

// What an event line tells besides its name, in order: keys and values.
using EventFields = std::vector<std::pair<absl::string_view, std::string>>;

// Writes one line to standard error, as logfmt: time, level, event, then the fields. Values with
// spaces are quoted. A thread of the log writes; where nobody reads standard error, the oldest of
// kLogLinesMax waiting lines are dropped, and a line log_lines_dropped reports how many.
// Threads: from any thread, never blocks on standard error; lines do not mix.
void LogEvent(LogLevel level, absl::string_view event, const EventFields& fields);
inline constexpr size_t kLogLinesMax = 1024;

// Returns when all lines so far are written, or after `timeout`. A process ends with it.
void FlushLog(absl::Duration timeout);

// Events below `level` are left out. Default: kInfo.
void SetLogLevel(LogLevel level);

}  // namespace procgen

#endif  // SERVER_LOGGING_EVENT_LOG_H_
