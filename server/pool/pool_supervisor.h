#ifndef SERVER_POOL_POOL_SUPERVISOR_H_
#define SERVER_POOL_POOL_SUPERVISOR_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "envcore/pool/pool.h"
#include "server/concurrency/background_executor.h"
#include "server/metrics/metrics.h"
#include "server/pool/history_sampler.h"
#include "server/pool/pool_registry.h"
#include "server/pool/pool_session.h"
#include "server/pool/quota/byte_budget.h"
#include "server/pool/quota/limits.h"
#include "server/pool/quota/quotas.h"
#include "server/pool/session_options.h"

namespace procgen {

// The pools of a server, which share its workers. Creates them within the limits, finds them, and
// drains. Threads: any method from any thread; none blocks.
class PoolSupervisor {
 public:
  using CreateDone = absl::AnyInvocable<void(absl::StatusOr<std::shared_ptr<PoolSession>>)>;

  // `worker_count` >= 1: threads that step environments. `metrics`: receives all counts; must
  // outlive this. `art`: what all pools draw with; null: the built-in art.
  PoolSupervisor(const Limits& limits, int32_t worker_count, Metrics* metrics,
                 std::shared_ptr<const SharedArt> art = nullptr);
  // Waits until all pools are freed. REQUIRES: every PoolSession will be released.
  ~PoolSupervisor();
  PoolSupervisor(const PoolSupervisor&) = delete;
  PoolSupervisor& operator=(const PoolSupervisor&) = delete;

  const Limits& limits() const { return limits_; }
  // The art that pools draw with; null: the built-in art.
  const SharedArt* art() const { return art_.get(); }
  // As SharedArt::fingerprint, of the art that pools draw with.
  uint64_t art_fingerprint() const {
    return art_ == nullptr ? SharedArt::Embedded()->fingerprint() : art_->fingerprint();
  }

  // The usage of each owner. This class counts pools; the services count calls.
  Quotas& quotas() { return quotas_; }
  // For long operations other than steps.
  BackgroundExecutor& executor() { return executor_; }
  // The server's metrics.
  Metrics& metrics() const { return *metrics_; }

  // Creates the pool `pools/ID` of `owner` and calls `done` once: on another thread or, with an
  // error, on this one. An empty `id` means a generated number. Errors: INVALID_ARGUMENT a
  // malformed id; ALREADY_EXISTS; RESOURCE_EXHAUSTED a limit; UNAVAILABLE while draining; those of
  // Pool::Create.
  void Create(absl::string_view owner, absl::string_view id, const PoolOptions& options,
              SessionOptions session_options, PoolSession::EndStream end_stream, CreateDone done);
  // Closes and removes a pool whose stream has ended.
  void Free(PoolSession* pool);

  // Finds a pool of `owner` by its name. Errors: INVALID_ARGUMENT a malformed name; NOT_FOUND.
  absl::StatusOr<std::shared_ptr<PoolSession>> Find(absl::string_view owner,
                                                    absl::string_view name) const {
    return pools_.Find(owner, name);
  }
  // At most `count` pools of `owner` made after pool number `after` (0: all), oldest first, with
  // their numbers.
  using Numbered = PoolRegistry::Numbered;
  std::vector<Numbered> List(absl::string_view owner, int64_t after, size_t count) const {
    return pools_.List(owner, after, count);
  }

  // Rejects new pools and subscribers from now on. Streams end with UNAVAILABLE once their current
  // requests are answered.
  void Drain();
  bool draining() const { return draining_; }
  // The error returned while draining: UNAVAILABLE.
  static absl::Status Draining();

  Load load() const;

 private:
  // Reserves quota and a name for a pool.
  absl::StatusOr<PoolRegistry::Key> Reserve(absl::string_view owner, absl::string_view id,
                                            const PoolOptions& options);
  // Creates a session that is freed on the background executor.
  std::shared_ptr<PoolSession> MakeSession(const PoolRegistry::Key& key, std::unique_ptr<Pool> pool,
                                           SessionOptions session_options,
                                           PoolSession::EndStream end_stream);

  const Limits limits_;
  Metrics* const metrics_;
  const std::shared_ptr<WorkerPool> workers_;
  const std::shared_ptr<const SharedArt> art_;
  std::atomic<int64_t> step_count_ = 0;
  Quotas quotas_;
  PoolRegistry pools_;  // after the quotas that its reservations refer to
  ByteBudget episode_bytes_;

  absl::Mutex mutex_;
  int32_t unfreed_count_ ABSL_GUARDED_BY(mutex_) = 0;  // PoolSessions that exist
  std::atomic<bool> draining_ = false;

  // Last, so that their threads end before the members that they use.
  BackgroundExecutor executor_;
  HistorySampler history_sampler_;
};

}  // namespace procgen

#endif  // SERVER_POOL_POOL_SUPERVISOR_H_
