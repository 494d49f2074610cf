#include "server/concurrency/start_thread.h"

#include <system_error>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"

namespace procgen {

absl::StatusOr<std::thread> StartThread(absl::AnyInvocable<void()> work) {
  try {
    return std::thread(std::move(work));
  } catch (const std::system_error& error) {
    return absl::ResourceExhaustedError(
        absl::StrCat("cannot start a thread: ", error.code().message(),
                     "; a limit on processes or memory is reached (ulimit -u, pids.max)"));
  }
}

absl::Status CheckThreadLimit(int count) {
  absl::Notification end;
  std::vector<std::thread> threads;
  absl::Status status;
  while (status.ok() && static_cast<int>(threads.size()) < count) {
    absl::StatusOr<std::thread> thread = StartThread([&end] { end.WaitForNotification(); });
    status = thread.status();
    if (thread.ok()) {
      threads.push_back(*std::move(thread));
    }
  }
  end.Notify();
  for (std::thread& thread : threads) {
    thread.join();
  }
  return status;
}

}  // namespace procgen
