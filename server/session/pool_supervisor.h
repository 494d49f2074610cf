#ifndef SERVER_SESSION_POOL_SUPERVISOR_H_
#define SERVER_SESSION_POOL_SUPERVISOR_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "envcore/pool/pool.h"
#include "server/concurrency/background_executor.h"
#include "server/concurrency/deadline_timer.h"
#include "server/metrics/metrics.h"
#include "server/session/backend/pool_backend.h"
#include "server/session/pool/pool_session.h"
#include "server/session/pool_registry.h"
#include "server/session/quota/byte_budget.h"
#include "server/session/quota/capacity.h"
#include "server/session/quota/limits.h"
#include "server/session/quota/memory_trimmer.h"
#include "server/session/quota/quotas.h"
#include "server/session/watch/frame_publishers.h"
#include "server/shared_memory/shared_memory_dir.h"

namespace procgen {

// Checks a lease duration. `field`: its name in errors. Errors: INVALID_ARGUMENT shorter than
// kLeaseDurationMin; RESOURCE_EXHAUSTED longer than the limit.
absl::Status CheckLeaseDuration(absl::string_view field, absl::Duration lease_duration,
                                const Limits& limits);

// The current load of a server.
struct Load {
  int32_t pool_count = 0;
  int32_t env_count = 0;
  int32_t stream_count = 0;
  int32_t worker_count = 0;
  int64_t step_count = 0;           // environment steps since the start
  int64_t resume_buffer_bytes = 0;  // reserved for answers of resumable streams
  bool draining = false;
};

// The pools of a server. Creates them within the limits, frees pools with expired leases, and
// drains.
// Threads: any method from any thread; none blocks.
class PoolSupervisor {
 public:
  using CreateDone = absl::AnyInvocable<void(absl::StatusOr<std::shared_ptr<PoolSession>>)>;

  // `worker_count` >= 1: threads that step environments. `metrics`: receives all counts; must
  // outlive this. `art`: what all pools draw with; null: the built-in art. `clock`: the clock of
  // leases. `shared_memory_dir`: where pools share memory with learners; null: not supported.
  // `backend_factory`: creates pools, with art and workers of its own; null: in this process.
  PoolSupervisor(const Limits& limits, int32_t worker_count, Metrics* metrics,
                 std::shared_ptr<const SharedArt> art = nullptr, Clock clock = SteadyNow,
                 std::shared_ptr<const SharedMemoryDir> shared_memory_dir = nullptr,
                 std::unique_ptr<PoolBackendFactory> backend_factory = nullptr);
  // Waits until all pools are freed. REQUIRES: every PoolSession will be released.
  ~PoolSupervisor();
  PoolSupervisor(const PoolSupervisor&) = delete;
  PoolSupervisor& operator=(const PoolSupervisor&) = delete;

  const Limits& limits() const { return limits_; }
  // The art that pools draw with; null: the built-in art.
  const SharedArt* art() const { return art_.get(); }

  // Whether pools can share memory with learners.
  bool shares_memory() const { return shared_memory_dir_ != nullptr; }
  // Whether learners find their pools again after the server restarts.
  bool keeps_pools() const { return backend_factory_->keeps_pools(); }

  // The usage of each owner. This class counts pools; the services count streams and calls.
  Quotas& quotas() { return quotas_; }
  // Frames for subscribers.
  FramePublishers& frame_publishers() { return frame_publishers_; }
  // For long operations other than steps.
  BackgroundExecutor& executor() { return executor_; }
  // The server's metrics.
  Metrics& metrics() const { return *metrics_; }

  // Creates the pool `pools/ID` of `owner` and calls `done` once: on another thread or, with an
  // error, on this one. An empty `id` means a generated number. REQUIRES: CheckLeaseDuration passes
  // or the lease is infinite; shares_memory() if the session shares memory. Errors:
  // INVALID_ARGUMENT a malformed id; ALREADY_EXISTS; RESOURCE_EXHAUSTED a limit; UNAVAILABLE while
  // draining; those of Pool::Create.
  void Create(absl::string_view owner, absl::string_view id, const PoolOptions& options,
              const SessionOptions& session_options, CreateDone done);

  // Restores the pools of earlier processes of this server. Call once at startup. The caller must
  // execute `requests` with `again` set before any other caller gets a turn. Pools beyond limits
  // that were lowered since are restored too.
  struct Resumed {
    std::shared_ptr<PoolSession> pool;
    std::vector<std::string> requests;
  };
  std::vector<Resumed> Resume();

  // Finds a pool of `owner` by its name. Errors: INVALID_ARGUMENT a malformed name; NOT_FOUND.
  absl::StatusOr<std::shared_ptr<PoolSession>> Find(absl::string_view owner,
                                                    absl::string_view name) const {
    return pools_.Find(owner, name);
  }

  // As Find, for a stream. Errors: UNAVAILABLE while draining.
  absl::StatusOr<std::shared_ptr<PoolSession>> FindForStream(absl::string_view owner,
                                                             absl::string_view name) const;

  // At most `count` pools of `owner` made after pool number `after` (0: all), oldest first, with
  // their numbers.
  using Numbered = PoolRegistry::Numbered;
  std::vector<Numbered> List(absl::string_view owner, int64_t after, size_t count) const {
    return pools_.List(owner, after, count);
  }
  // All pools of all owners. Must not be exposed to other owners.
  std::vector<std::shared_ptr<PoolSession>> ListAll() const { return pools_.All(); }

  // Deletes a pool of `owner`. Its stream ends with ABORTED. Errors: as Find.
  absl::Status Delete(absl::string_view owner, absl::string_view name);

  // Frees all pools whose leases expired by `now`. Returns when the next lease expires; the lease
  // timer calls this at that time.
  absl::Time FreeExpired(absl::Time now);

  // Rejects new pools, streams and subscribers from now on. Streams end with UNAVAILABLE once their
  // current requests are answered.
  void Drain();
  bool draining() const { return draining_; }
  // Pools left whose streams were ended by Drain. Their learners may still save states and then
  // delete the pools. 0 if pools are kept.
  int32_t LeavingCount() const { return pools_.LeavingCount(); }
  // The error returned while draining: UNAVAILABLE.
  absl::Status Draining() const;

  Load load() const;

 private:
  // Reserves capacity, quota and a name for a pool.
  absl::StatusOr<PoolRegistry::Key> Reserve(absl::string_view owner, absl::string_view id,
                                            const PoolOptions& options);
  // Appends to a RESOURCE_EXHAUSTED error how many pools of `owner` have no stream attached.
  absl::Status WithIdlePools(const absl::Status& error, absl::string_view owner) const;
  // Creates a session that is freed on the background executor.
  std::shared_ptr<PoolSession> MakeSession(const CreatePoolOptions& create_options,
                                           std::unique_ptr<PoolBackend> pool);
  void Finish(const PoolRegistry::Key& key, absl::StatusOr<std::unique_ptr<PoolBackend>> pool,
              const SessionOptions& session_options, CreateDone done);

  const Limits limits_;
  Metrics* const metrics_;
  const std::shared_ptr<const SharedArt> art_;
  std::atomic<int64_t> step_count_ = 0;
  MemoryTrimmer memory_trimmer_;
  Quotas quotas_;
  Capacity capacity_;
  PoolRegistry pools_;  // after the members that its reservations refer to
  ByteBudget resume_buffer_bytes_;
  ByteBudget shared_memory_bytes_;
  ByteBudget episode_bytes_;
  const std::shared_ptr<const SharedMemoryDir> shared_memory_dir_;

  absl::Mutex mutex_;
  int32_t unfreed_count_ ABSL_GUARDED_BY(mutex_) = 0;  // PoolSessions that exist
  std::atomic<bool> draining_ = false;

  // Last, so that their threads end before the members that they use.
  BackgroundExecutor executor_;
  const std::unique_ptr<PoolBackendFactory> backend_factory_;
  DeadlineTimer lease_timer_;
  FramePublishers frame_publishers_;
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_SUPERVISOR_H_
