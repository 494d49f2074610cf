#ifndef SERVER_SHARED_MEMORY_PIPE_LISTENER_H_
#define SERVER_SHARED_MEMORY_PIPE_LISTENER_H_

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
#include "server/shared_memory/file_descriptor.h"
#include "server/shared_memory/pipe_connection.h"

namespace procgen {

// A stream whose learner may come by pipes. All calls are made on the pipes' thread.
// Messages are received by whoever finds the time, on any thread, one at a time; who finds none has
// the pipes watched.
class PipeConnectionUser {
 public:
  virtual ~PipeConnectionUser() = default;

  // The learner has come, once. The pipes may be used until they end.
  virtual void OnPipesOpened(std::shared_ptr<PipeConnection> pipes) = 0;
  // There is something to receive, or the pipes have ended, and were watched; or this side has hung
  // up. Must not block for long.
  virtual void OnPipesInput() = 0;
};

// Where learners on this machine open pipes to their streams: a unix socket without a file,
// which is gone with the process. Only processes of the same user are let in, and each must show
// the key of its stream; who has shown it is given the learner's ends of the pipes, and the
// connection ends. A PipeConnection has a thread, which waits where nobody else finds its messages.
// Threads: any method from any thread.
class PipeListener {
 public:
  static constexpr size_t kKeyBytes = 16;

  // `message_bytes_max`: of what a learner sends. Errors: RESOURCE_EXHAUSTED no socket can be made.
  static absl::StatusOr<std::unique_ptr<PipeListener>> Open(size_t message_bytes_max);
  // Ends all pipes, and waits for their threads.
  ~PipeListener();
  PipeListener(const PipeListener&) = delete;
  PipeListener& operator=(const PipeListener&) = delete;

  // The socket's name among those that have no file, without the byte 0 at its beginning.
  const std::string& socket_name() const { return socket_name_; }

  // Lets the first who shows the key, [kKeyBytes], speak to `user`.
  std::string Expect(std::weak_ptr<PipeConnectionUser> user);
  // Lets nobody come by this key any more.
  void Forget(const std::string& key);

 private:
  // Of one who has come: a connection until a key is shown, and then pipes; and its thread.
  struct Visit {
    FileDescriptor connection;  // changed by the thread only, under the lock
    std::shared_ptr<PipeConnection> pipes;
    std::thread thread;
    bool is_over = false;  // the thread is at its end
  };

  PipeListener(int socket, std::string socket_name, size_t message_bytes_max);
  void AcceptUntilStopped();
  void Begin(FileDescriptor connection);
  // What a visit's thread does.
  void Receive(Visit* visit);
  // The stream to which who has come shows a key; null: none.
  std::shared_ptr<PipeConnectionUser> Identify(int connection);
  // Makes pipes for who has come; null: it is gone, or no more can be made or are wanted.
  std::shared_ptr<PipeConnection> OpenPipes(Visit* visit);
  // Whom a key is for, once; null: nobody.
  std::shared_ptr<PipeConnectionUser> Claim(absl::string_view key);
  // Waits for threads that are at their ends.
  void Reap() ABSL_LOCKS_EXCLUDED(mutex_);

  const int socket_;
  const std::string socket_name_;
  const size_t message_bytes_max_;

  absl::Mutex mutex_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  int unknown_count_ ABSL_GUARDED_BY(mutex_) = 0;  // visits that have shown no key yet
  std::list<Visit> visits_ ABSL_GUARDED_BY(mutex_);
  std::unordered_map<std::string, std::weak_ptr<PipeConnectionUser>> expected_
      ABSL_GUARDED_BY(mutex_);
  std::thread accepting_;  // the last, as it uses all others
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_PIPE_LISTENER_H_
