#ifndef SERVER_CLUSTER_DDS_LOG_H_
#define SERVER_CLUSTER_DDS_LOG_H_

#include <string>

#include "absl/strings/string_view.h"

namespace procgen {

// Reports to whom LogClusterTo named.
void LogOfCluster(bool is_error, absl::string_view message);

// While there is one, what Cyclone DDS calls an error is collected here and not logged: its error
// codes do not tell what is wrong, its log does. One at a time in a process; another one waits.
class DdsComplaints {
 public:
  DdsComplaints();
  ~DdsComplaints();
  DdsComplaints(const DdsComplaints&) = delete;
  DdsComplaints& operator=(const DdsComplaints&) = delete;

  // All so far, "; " between them.
  std::string text() const;

 private:
  std::string text_;  // of the log, and under its lock
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_DDS_LOG_H_
