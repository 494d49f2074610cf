#include "server/concurrency/thread_limit.h"

#include <system_error>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"

namespace procgen {

absl::Status CheckThreadLimit(int count) {
  absl::Notification end;
  std::vector<std::thread> threads;
  absl::Status status;
  try {
    while (static_cast<int>(threads.size()) < count) {
      threads.emplace_back([&end] { end.WaitForNotification(); });
    }
  } catch (const std::system_error& error) {
    status = absl::ResourceExhaustedError(
        absl::StrCat("cannot start a thread: ", error.code().message(),
                     "; a limit on processes or memory is reached (ulimit -u, pids.max)"));
  }
  end.Notify();
  for (std::thread& thread : threads) {
    thread.join();
  }
  return status;
}

}  // namespace procgen
