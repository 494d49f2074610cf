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

// A stream that can be served over pipes. All calls are made on the pipes' thread.
// Any thread may receive messages, one at a time; a thread that finds none has the pipes watched.
class PipeConnectionUser {
 public:
  virtual ~PipeConnectionUser() = default;

  // The learner has connected; called once. The pipes are usable until they end.
  virtual void OnPipesOpened(std::shared_ptr<PipeConnection> pipes) = 0;
  // Watched pipes have input or have ended, or this side has hung up. Must not block for long.
  virtual void OnPipesInput() = 0;
};

// Accepts learners on this machine that open pipes to their streams, on a unix socket in the
// abstract namespace. Peers must be processes of the same user and send the key of their stream.
// They then receive their ends of the pipes, and the socket connection ends. Each PipeConnection
// has a thread, which waits for messages that no other thread polls for.
// Threads: any method from any thread.
class PipeListener {
 public:
  static constexpr size_t kKeyBytes = 16;

  // `message_bytes_max`: of a learner's messages. Errors: RESOURCE_EXHAUSTED no socket can be
  // created.
  static absl::StatusOr<std::unique_ptr<PipeListener>> Open(size_t message_bytes_max);
  // Ends all pipes and waits for their threads.
  ~PipeListener();
  PipeListener(const PipeListener&) = delete;
  PipeListener& operator=(const PipeListener&) = delete;

  // The socket's abstract name, without the leading byte 0.
  const std::string& socket_name() const { return socket_name_; }

  // Connects the first peer that sends the key, [kKeyBytes], to `user`.
  std::string Expect(std::weak_ptr<PipeConnectionUser> user);
  // Revokes a key.
  void Forget(const std::string& key);

 private:
  // One peer: its socket connection until the key has arrived, then its pipes; and its thread.
  struct Visit {
    FileDescriptor connection;  // changed only by the thread, under the lock
    std::shared_ptr<PipeConnection> pipes;
    std::thread thread;
    bool is_over = false;  // the thread is about to end
  };

  PipeListener(int socket, std::string socket_name, size_t message_bytes_max);
  void AcceptUntilStopped();
  void Begin(FileDescriptor connection);
  // The main function of a visit's thread.
  void Receive(Visit* visit);
  // Receives the key and returns its stream; null: none.
  std::shared_ptr<PipeConnectionUser> Identify(int connection);
  // Opens pipes for a peer; null: it is gone, or no more can be opened.
  std::shared_ptr<PipeConnection> OpenPipes(Visit* visit);
  // Returns the user of a key and revokes it; null: unknown key.
  std::shared_ptr<PipeConnectionUser> Claim(absl::string_view key);
  // Joins threads that have ended.
  void Reap() ABSL_LOCKS_EXCLUDED(mutex_);

  const int socket_;
  const std::string socket_name_;
  const size_t message_bytes_max_;

  absl::Mutex mutex_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  int unknown_count_ ABSL_GUARDED_BY(mutex_) = 0;  // visits without a key yet
  std::list<Visit> visits_ ABSL_GUARDED_BY(mutex_);
  std::unordered_map<std::string, std::weak_ptr<PipeConnectionUser>> expected_
      ABSL_GUARDED_BY(mutex_);
  std::thread accepting_;  // last, as it uses the other members
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_PIPE_LISTENER_H_
