#include "server/pool/pool_supervisor.h"

#include <malloc.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

constexpr int32_t kBackgroundThreadCount = 2;

}  // namespace

PoolSupervisor::PoolSupervisor(const Limits& limits, int32_t worker_count, Metrics* metrics,
                               std::shared_ptr<const SharedArt> art)
    : limits_(limits),
      metrics_(metrics),
      workers_(std::make_shared<WorkerPool>(worker_count)),
      art_(std::move(art)),
      quotas_(limits),
      episode_bytes_(limits.episode_history_bytes_max),
      executor_(kBackgroundThreadCount),
      history_sampler_([this] { return pools_.All(); }) {}

PoolSupervisor::~PoolSupervisor() {
  pools_.Clear();
  const auto all_freed = [this]()
                             ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return unfreed_count_ == 0; };
  absl::MutexLock lock(&mutex_, absl::Condition(&all_freed));
}

absl::StatusOr<PoolRegistry::Key> PoolSupervisor::Reserve(absl::string_view owner,
                                                          absl::string_view id,
                                                          const PoolOptions& options) {
  if (draining_) {
    return Draining();
  }
  if (options.env_count < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("spec.env_count is ", options.env_count, ", allowed: at least 1"));
  }
  absl::StatusOr<Quotas::Reservation> reservation = quotas_.Reserve(
      owner, {.env_count = options.env_count,
              .bytes = PoolBytes(options.env_count,
                                 static_cast<int64_t>(options.observation_format.bytes()))});
  if (!reservation.ok()) {
    return reservation.status();
  }
  return pools_.Reserve(owner, id, *std::move(reservation));
}

void PoolSupervisor::Create(absl::string_view owner, absl::string_view id,
                            const PoolOptions& options, SessionOptions session_options,
                            PoolSession::EndStream end_stream, CreateDone done) {
  absl::StatusOr<PoolRegistry::Key> key = Reserve(owner, id, options);
  if (!key.ok()) {
    done(key.status());
    return;
  }
  PoolOptions drawn = options;
  drawn.art = art_;
  executor_.Run(
      std::string(owner), [this, key = *std::move(key), drawn = std::move(drawn),
                           session_options = std::move(session_options),
                           end_stream = std::move(end_stream), done = std::move(done)]() mutable {
        absl::StatusOr<std::unique_ptr<Pool>> pool = Pool::Create(drawn, workers_);
        if (!pool.ok()) {
          pools_.Remove(key);
          done(pool.status());
          return;
        }
        std::shared_ptr<PoolSession> session =
            MakeSession(key, *std::move(pool), std::move(session_options), std::move(end_stream));
        pools_.Put(key, session);
        LogEvent(LogLevel::kInfo, "pool_created",
                 {{"pool", session->name()},
                  {"owner", session->owner()},
                  {"games", session->options().games.front()},
                  {"environments", absl::StrCat(session->env_count())}});
        done(std::move(session));
      });
}

std::shared_ptr<PoolSession> PoolSupervisor::MakeSession(const PoolRegistry::Key& key,
                                                         std::unique_ptr<Pool> pool,
                                                         SessionOptions session_options,
                                                         PoolSession::EndStream end_stream) {
  {
    absl::MutexLock lock(&mutex_);
    ++unfreed_count_;
  }
  // Shared by the registry and current callers. Freed on the background executor, because the last
  // reference may be dropped by a worker of the pool's own worker pool.
  return {
      new PoolSession(key.first, key.second, std::move(pool), std::move(session_options),
                      std::move(end_stream), {&executor_, &episode_bytes_, &step_count_, metrics_}),
      [this](PoolSession* freed) {
        executor_.Run(freed->owner(), [this, freed] {
          delete freed;
          malloc_trim(0);  // glibc keeps freed memory of several arenas
          absl::MutexLock lock(&mutex_);
          --unfreed_count_;
        });
      }};
}

void PoolSupervisor::Free(PoolSession* pool) {
  if (pools_.Remove(*pool)) {
    pool->Close(absl::AbortedError(absl::StrCat("pool ", pool->name(), " ended with its stream")));
    LogEvent(LogLevel::kInfo, "pool_freed", {{"pool", pool->name()}, {"owner", pool->owner()}});
  }
}

absl::Status PoolSupervisor::Draining() {
  return absl::UnavailableError("the server drains and will stop; use another server");
}

void PoolSupervisor::Drain() {
  draining_ = true;
  for (const std::shared_ptr<PoolSession>& pool : pools_.All()) {
    pool->EndObservers(Draining());  // first, because the pool ends with its stream
    pool->End(Draining());
  }
}

Load PoolSupervisor::load() const {
  return {.pool_count = static_cast<int32_t>(pools_.All().size()),
          .env_count = static_cast<int32_t>(quotas_.env_count()),
          .worker_count = workers_->thread_count(),
          .step_count = step_count_,
          .draining = draining_};
}

}  // namespace procgen
