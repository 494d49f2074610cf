#ifndef SERVER_SESSION_EVENT_LOG_H_
#define SERVER_SESSION_EVENT_LOG_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"

namespace procgen {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

// What an event line tells besides its name, in order: keys and values.
using EventFields = std::vector<std::pair<absl::string_view, std::string>>;

// Writes one line to standard error, as logfmt: time, level, event, then the fields. Values with
// spaces are quoted. Threads: from any thread; lines do not mix.
void LogEvent(LogLevel level, absl::string_view event, const EventFields& fields);

// Events below `level` are left out. Default: kInfo.
void SetLogLevel(LogLevel level);

}  // namespace procgen

#endif  // SERVER_SESSION_EVENT_LOG_H_
