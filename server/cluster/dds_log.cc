#include "server/cluster/dds_log.h"

#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/string_view.h"
#include "dds/dds.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

void Log(void* /*none*/, const dds_log_data_t* line) {
  const bool is_error = (line->priority & (DDS_LC_FATAL | DDS_LC_ERROR)) != 0;
  LogOfCluster(is_error ? LogLevel::kError : LogLevel::kWarning,
               absl::StripAsciiWhitespace(absl::string_view(line->message, line->size)));
}

}  // namespace

void LogOfCluster(LogLevel level, absl::string_view message) {
  LogEvent(level, "cluster", {{"message", std::string(message)}});
}

void LogErrorsOfDds() { dds_set_log_sink(Log, nullptr); }

}  // namespace procgen
