#ifndef SERVER_CLUSTER_DDS_LOG_H_
#define SERVER_CLUSTER_DDS_LOG_H_

#include "absl/strings/string_view.h"
#include "server/logging/event_log.h"

namespace procgen {

// Logs an event "cluster".
void LogOfCluster(LogLevel level, absl::string_view message);

// Makes Cyclone DDS log such events, too: its error codes do not explain an error, its log does.
void LogErrorsOfDds();

}  // namespace procgen

#endif  // SERVER_CLUSTER_DDS_LOG_H_
