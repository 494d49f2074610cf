#ifndef SERVER_LOGGING_EVENT_LOG_H_
#define SERVER_LOGGING_EVENT_LOG_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace procgen {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

// Keys and values of an event, in order.
using EventFields = std::vector<std::pair<absl::string_view, std::string>>;

// Writes one logfmt line to standard error: time, level, event, then the fields. Values with spaces
// are quoted. A separate thread writes. If nothing reads standard error, the oldest of kLogLinesMax
// waiting lines are dropped.
// Threads: from any thread; never blocks on standard error. Lines are not interleaved.
void LogEvent(LogLevel level, absl::string_view event, const EventFields& fields);
inline constexpr size_t kLogLinesMax = 1024;

// Returns when all lines so far are written, or after `timeout`. Called before the process exits.
void FlushLog(absl::Duration timeout);

// Omits events below `level`. Default: kInfo.
void SetLogLevel(LogLevel level);

}  // namespace procgen

#endif  // SERVER_LOGGING_EVENT_LOG_H_
