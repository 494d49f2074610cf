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
#include "server/shared_memory/shared_folder.h"

namespace procgen {

// Checks how long a pool is to live without a stream. `field` is what to call it. Errors:
// INVALID_ARGUMENT shorter than kLeaseDurationMin; RESOURCE_EXHAUSTED longer than the limit.
absl::Status CheckLeaseDuration(absl::string_view field, absl::Duration lease_duration,
                                const Limits& limits);

// How busy a server is.
struct Load {
  int32_t pool_count = 0;
  int32_t env_count = 0;
  int32_t stream_count = 0;
  int32_t worker_count = 0;
  int64_t step_count = 0;           // environment steps since the start
  int64_t resume_buffer_bytes = 0;  // reserved for answers of streams that may be resumed
  bool draining = false;
};

// The pools of a server: makes them within its limits, frees those whose leases have run out, and
// drains.
// Threads: any method from any thread; none blocks.
class PoolSupervisor {
 public:
  using CreateDone = absl::AnyInvocable<void(absl::StatusOr<std::shared_ptr<PoolSession>>)>;

  // `worker_count` >= 1 threads step environments. All pools draw with `art`; null: the built-in.
  // Leases run by `clock`. What is done is counted in `metrics`, which must outlive this.
  // `shared_folder`: where pools share memory with learners; null: none does. `backend_factory`:
  // where pools are made, with art and workers of its own; null: in this process.
  PoolSupervisor(const Limits& limits, int32_t worker_count, Metrics* metrics,
                 std::shared_ptr<const SharedArt> art = nullptr, Clock clock = SteadyNow,
                 std::shared_ptr<const SharedFolder> shared_folder = nullptr,
                 std::unique_ptr<PoolBackendFactory> backend_factory = nullptr);
  // Waits until all pools are freed. REQUIRES: nobody holds a PoolSession for good.
  ~PoolSupervisor();
  PoolSupervisor(const PoolSupervisor&) = delete;
  PoolSupervisor& operator=(const PoolSupervisor&) = delete;

  const Limits& limits() const { return limits_; }
  // What pools draw with; null: the built-in art.
  const SharedArt* art() const { return art_.get(); }

  // Whether pools can share memory with learners.
  bool shares_memory() const { return shared_folder_ != nullptr; }
  // Whether learners find their pools here again when the server has been stopped and started.
  bool keeps_pools() const { return backend_factory_->keeps_pools(); }

  // What each owner holds. Pools are counted there by this; streams and calls by who serves them.
  Quotas& quotas() { return quotas_; }
  // Who watches what.
  FramePublishers& frame_publishers() { return frame_publishers_; }
  // For what takes long and is no step.
  BackgroundExecutor& executor() { return executor_; }
  // Where all that the server does is counted.
  Metrics& metrics() const { return *metrics_; }

  // Makes the pool `pools/ID` of `owner` (an empty id: a number is chosen), and calls `done` once,
  // on another thread or, with an error, on this one. REQUIRES: CheckLeaseDuration, or infinite;
  // shares_memory(), if it shares any. Errors: INVALID_ARGUMENT a malformed id; ALREADY_EXISTS;
  // RESOURCE_EXHAUSTED a limit; UNAVAILABLE while draining; those of Pool::Create.
  void Create(absl::string_view owner, absl::string_view id, const PoolOptions& options,
              const SessionOptions& session_options, CreateDone done);

  // The pools that earlier processes of this server left, which are there again, to be called once
  // at the start; what is to be carried out `again` is for the caller to do, and no turn of another
  // comes before that. Those that exceed limits that have become less are there all the same.
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
  // All pools, whoever owns them, to be told to nobody else.
  std::vector<std::shared_ptr<PoolSession>> ListAll() const { return pools_.All(); }

  // Ends a pool of `owner`. Its stream ends with ABORTED. Errors: as Find.
  absl::Status Delete(absl::string_view owner, absl::string_view name);

  // Frees all pools whose leases have run out by `now`, and returns when the next one does; the
  // alarm calls it in time.
  absl::Time FreeExpired(absl::Time now);

  // Lets no pool be made, no stream attach and nobody watch any more, and ends all streams with
  // UNAVAILABLE once the requests that they are carrying out are answered.
  void Drain();
  bool draining() const { return draining_; }
  // Pools that are still there and whose streams were told so: their learners may want to save
  // states, and delete them when they have. None where pools are kept.
  int32_t LeavingCount() const { return pools_.LeavingCount(); }
  // What is answered while draining: UNAVAILABLE.
  absl::Status Draining() const;

  Load load() const;

 private:
  // Takes room for a pool, and a name.
  absl::StatusOr<PoolRegistry::Key> Reserve(absl::string_view owner, absl::string_view id,
                                            const PoolOptions& options);
  // A session that is freed where it can be.
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
  PoolRegistry pools_;  // after those that its pools have reservations of
  ByteBudget resume_buffer_bytes_;
  ByteBudget shared_memory_bytes_;
  ByteBudget episode_bytes_;
  const std::shared_ptr<const SharedFolder> shared_folder_;

  absl::Mutex mutex_;
  int32_t unfreed_count_ ABSL_GUARDED_BY(mutex_) = 0;  // PoolSessions that exist
  std::atomic<bool> draining_ = false;

  // Last, so that their threads end before what they use.
  BackgroundExecutor executor_;
  const std::unique_ptr<PoolBackendFactory> backend_factory_;
  DeadlineTimer lease_timer_;
  FramePublishers frame_publishers_;
};

}  // namespace procgen

#endif  // SERVER_SESSION_POOL_SUPERVISOR_H_
