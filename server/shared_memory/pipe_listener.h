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
#include "server/shared_memory/file_descriptor.h"

namespace procgen {

// A stream whose learner may come by a direct line. All calls are made on the line's thread.
// Messages are received by whoever finds the time, on any thread, one at a time; who finds none has
// the line watched.
class DirectLineUser {
 public:
  virtual ~DirectLineUser() = default;

  // The learner has come, once. The line may be used until it ends.
  virtual void OnLineOpened(std::shared_ptr<DirectLine> line) = 0;
  // There is something to receive, or the line has ended, and it was watched; or this side has hung
  // up. Must not block for long.
  virtual void OnLineInput() = 0;
};

// Where learners on this machine open direct lines to their streams: a unix socket without a file,
// which is gone with the process. Only processes of the same user are let in, and each must show
// the key of its stream; who has shown it is given the learner's ends of the line, and the
// connection ends. A line has a thread, which waits where nobody else finds its messages.
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
  // Of one who has come: a connection until a key is shown, and then a line; and its thread.
  struct Visit {
    FileDescriptor connection;  // changed by the thread only, under the lock
    std::shared_ptr<DirectLine> line;
    std::thread thread;
    bool is_over = false;  // the thread is at its end
  };

  DirectLines(int socket, std::string socket_name, size_t message_bytes_max);
  void AcceptUntilStopped();
  void Begin(FileDescriptor connection);
  // What a visit's thread does.
  void Receive(Visit* visit);
  // The stream to which who has come shows a key; null: none.
  std::shared_ptr<DirectLineUser> Identify(int connection);
  // Makes a line for who has come; null: it is gone, or no more line can be made or is wanted.
  std::shared_ptr<DirectLine> MakeLine(Visit* visit);
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
