#ifndef SERVER_SHARED_MEMORY_DIRECT_LINES_H_
#define SERVER_SHARED_MEMORY_DIRECT_LINES_H_

#include <cstddef>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <unordered_map>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "server/shared_memory/direct_line.h"

namespace procgen {

// A stream whose learner may come by a direct line. All calls are made on the line's thread.
class DirectLineUser {
 public:
  virtual ~DirectLineUser() = default;

  // The learner has come, once. The line may be used until it ends.
  virtual void OnLineOpened(std::shared_ptr<DirectLine> line) = 0;
  // Takes a message, or, last of all, why there will be none: CANCELLED the learner has ended the
  // line; RESOURCE_EXHAUSTED a message is too large. Blocks while the stream takes none; false: it
  // wants no more.
  virtual bool OnLineMessage(const absl::StatusOr<absl::string_view>& message) = 0;
};

// Where learners on this machine open direct lines to their streams: a unix socket without a file,
// which is gone with the process. Only processes of the same user are let in, and each must show
// the key of its stream. A line has a thread, which waits for its messages and hands them on.
// Threads: any method from any thread.
class DirectLines {
 public:
  static constexpr size_t kKeyBytes = 16;

  // `message_bytes_max`: of what a learner sends. Errors: RESOURCE_EXHAUSTED no socket can be made.
  static absl::StatusOr<std::unique_ptr<DirectLines>> Open(size_t message_bytes_max);
  // Ends all lines, and waits for their threads.
  ~DirectLines();
  DirectLines(const DirectLines&) = delete;
  DirectLines& operator=(const DirectLines&) = delete;

  // The socket's name among those that have no file, without the byte 0 at its beginning.
  const std::string& socket_name() const { return socket_name_; }

  // Lets the first who shows the key, [kKeyBytes], speak to `user`.
  std::string Expect(std::weak_ptr<DirectLineUser> user);
  // Lets nobody come by this key any more.
  void Forget(const std::string& key);

 private:
  // Of one who has come: its line, its thread, and whether that is at its end.
  struct Visit {
    std::shared_ptr<DirectLine> line;
    std::thread thread;
    bool is_over = false;
  };

  DirectLines(int socket, std::string socket_name, size_t message_bytes_max);
  void AcceptUntilStopped();
  void Begin(int connection);
  void Receive(const std::shared_ptr<DirectLine>& line);
  // Whom a key is for, once; null: nobody.
  std::shared_ptr<DirectLineUser> Claim(absl::string_view key);
  // Waits for threads that are at their ends.
  void Reap() ABSL_LOCKS_EXCLUDED(mutex_);

  const int socket_;
  const std::string socket_name_;
  const size_t message_bytes_max_;

  absl::Mutex mutex_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  int unknown_count_ ABSL_GUARDED_BY(mutex_) = 0;  // visits that have shown no key yet
  std::list<Visit> visits_ ABSL_GUARDED_BY(mutex_);
  std::unordered_map<std::string, std::weak_ptr<DirectLineUser>> expected_ ABSL_GUARDED_BY(mutex_);
  std::thread accepting_;  // the last, as it uses all others
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_DIRECT_LINES_H_
