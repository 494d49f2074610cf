#ifndef SERVER_CLUSTER_DDS_LOG_H_
#define SERVER_CLUSTER_DDS_LOG_H_

#include <string>

#include "absl/strings/string_view.h"

namespace procgen {

// Logs to the target of LogClusterTo.
void LogOfCluster(bool is_error, absl::string_view message);

// Collects errors of Cyclone DDS while it exists, in place of logging them: the log explains an
// error, the error code does not. One at a time in a process; another one blocks.
class DdsErrorLog {
 public:
  DdsErrorLog();
  ~DdsErrorLog();
  DdsErrorLog(const DdsErrorLog&) = delete;
  DdsErrorLog& operator=(const DdsErrorLog&) = delete;

  // All errors so far, separated by "; ".
  std::string text() const;

 private:
  std::string text_;  // written by the log, and guarded by its lock
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_DDS_LOG_H_
