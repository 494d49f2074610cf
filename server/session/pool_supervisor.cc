#include "server/session/pool_supervisor.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/logging/event_log.h"
#include "server/session/backend/local_pool.h"

namespace procgen {
namespace {

constexpr int32_t kBackgroundThreadCount = 2;

int64_t FrameBytes(const PoolOptions& options) {
  return static_cast<int64_t>(options.observation_format.bytes());
}

}  // namespace

absl::Status CheckLeaseDuration(absl::string_view field, absl::Duration lease_duration,
                                const Limits& limits) {
  if (lease_duration < kLeaseDurationMin) {
    return absl::InvalidArgumentError(
        absl::StrCat(field, " is ", absl::FormatDuration(lease_duration),
                     ", allowed: 0 (no lease), or ", absl::FormatDuration(kLeaseDurationMin),
                     " to ", absl::FormatDuration(limits.lease_duration_max)));
  }
  if (lease_duration > limits.lease_duration_max) {
    return absl::ResourceExhaustedError(absl::StrCat(
        field, " is ", absl::FormatDuration(lease_duration), ", limit lease_duration_max is ",
        absl::FormatDuration(limits.lease_duration_max)));
  }
  return absl::OkStatus();
}

PoolSupervisor::PoolSupervisor(const Limits& limits, int32_t worker_count, Metrics* metrics,
                               std::shared_ptr<const SharedArt> art, Clock clock,
                               std::shared_ptr<const SharedMemoryDir> shared_memory_dir,
                               std::unique_ptr<PoolBackendFactory> backend_factory)
    : limits_(limits),
      metrics_(metrics),
      art_(std::move(art)),
      quotas_(limits, [this] { memory_trimmer_.Request(); }),
      capacity_(limits),
      resume_buffer_bytes_(limits.resume_buffer_bytes_max),
      shared_memory_bytes_(limits.shared_memory_bytes_max),
      episode_bytes_(limits.episode_history_bytes_max),
      shared_memory_dir_(std::move(shared_memory_dir)),
      executor_(kBackgroundThreadCount),
      backend_factory_(backend_factory != nullptr
                           ? std::move(backend_factory)
                           : std::make_unique<LocalPoolFactory>(worker_count, art_, &executor_)),
      lease_timer_(std::move(clock), [this](absl::Time now) { return FreeExpired(now); }) {}

PoolSupervisor::~PoolSupervisor() {
  pools_.Clear();
  const auto all_freed = [this]()
                             ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return unfreed_count_ == 0; };
  absl::MutexLock lock(&mutex_, absl::Condition(&all_freed));
}

void PoolSupervisor::Create(absl::string_view owner, absl::string_view id,
                            const PoolOptions& options, const SessionOptions& session_options,
                            CreateDone done) {
  absl::StatusOr<PoolRegistry::Key> key = Reserve(owner, id, options);
  if (!key.ok()) {
    done(key.status());
    return;
  }
  const CreatePoolOptions create_options = {key->first, key->second, options, session_options};
  backend_factory_->Create(create_options,
                           [this, key = *std::move(key), session_options, done = std::move(done)](
                               absl::StatusOr<std::unique_ptr<PoolBackend>> pool) mutable {
                             Finish(key, std::move(pool), session_options, std::move(done));
                           });
}

absl::Status PoolSupervisor::WithIdlePools(const absl::Status& error,
                                           absl::string_view owner) const {
  const auto pools = pools_.List(owner, 0, std::numeric_limits<size_t>::max());
  const auto idle_count = std::count_if(
      pools.begin(), pools.end(), [](const auto& numbered) { return !numbered.pool->attached(); });
  if (error.code() != absl::StatusCode::kResourceExhausted || idle_count == 0) {
    return error;
  }
  return {
      error.code(),
      absl::StrCat(error.message(), "; ", idle_count, " of ", pools.size(),
                   " own pools without an attached learner: DeletePool or `procgen-top --delete` "
                   "frees one")};
}

absl::StatusOr<PoolRegistry::Key> PoolSupervisor::Reserve(absl::string_view owner,
                                                          absl::string_view id,
                                                          const PoolOptions& options) {
  if (draining_) {
    return Draining();
  }
  absl::StatusOr<Capacity::Reservation> room =
      capacity_.Reserve(options.env_count, FrameBytes(options));
  if (!room.ok()) {
    return WithIdlePools(room.status(), owner);
  }
  absl::StatusOr<Quotas::Reservation> reservation =
      quotas_.Reserve(owner, {.pool_count = 1, .env_count = options.env_count});
  if (!reservation.ok()) {
    return WithIdlePools(reservation.status(), owner);
  }
  return pools_.Reserve(owner, id, {*std::move(room), *std::move(reservation)});
}

void PoolSupervisor::Finish(const PoolRegistry::Key& key,
                            absl::StatusOr<std::unique_ptr<PoolBackend>> pool,
                            const SessionOptions& session_options, CreateDone done) {
  if (!pool.ok()) {
    pools_.Remove(key);
    done(pool.status());
    return;
  }
  const CreatePoolOptions create_options = {key.first, key.second, (*pool)->options(),
                                            session_options};
  std::shared_ptr<PoolSession> session = MakeSession(create_options, *std::move(pool));
  pools_.Put(key, session);
  LogEvent(LogLevel::kInfo, "pool_created",
           {{"pool", session->name()},
            {"owner", session->owner()},
            {"games", session->options().games.front()},
            {"environments", absl::StrCat(session->env_count())}});
  done(std::move(session));
}

std::shared_ptr<PoolSession> PoolSupervisor::MakeSession(const CreatePoolOptions& create_options,
                                                         std::unique_ptr<PoolBackend> pool) {
  {
    absl::MutexLock lock(&mutex_);
    ++unfreed_count_;
  }
  const SessionOptions& session_options = create_options.session_options;
  // Shared by the registry and current callers. Freed on the background executor, because the last
  // reference may be dropped by a worker of the pool's own worker pool.
  return {new PoolSession(create_options.owner, create_options.name, std::move(pool),
                          session_options.lease_duration,
                          {&quotas_, &executor_, &lease_timer_, &resume_buffer_bytes_,
                           &shared_memory_bytes_, &episode_bytes_, &step_count_, metrics_},
                          session_options.encoding,
                          session_options.shares_memory ? shared_memory_dir_.get() : nullptr),
          [this](PoolSession* freed) {
            executor_.Run(freed->owner(), [this, freed] {
              delete freed;
              memory_trimmer_.Request();
              absl::MutexLock lock(&mutex_);
              --unfreed_count_;
            });
          }};
}

std::vector<PoolSupervisor::Resumed> PoolSupervisor::Resume() {
  std::vector<Resumed> all;
  for (ResumedPool& resumed : backend_factory_->TakeResumed()) {
    const CreatePoolOptions& create_options = resumed.create_options;
    Resumed session = {MakeSession(create_options, std::move(resumed.pool)),
                       std::move(resumed.requests)};
    session.pool->ResumeAt(resumed.next_sequence_number);
    absl::StatusOr<Quotas::Reservation> reservation = quotas_.Reserve(
        create_options.owner, {.pool_count = 1, .env_count = create_options.options.env_count});
    all.push_back(session);
    pools_.Add(session.pool, {capacity_.Count(create_options.options.env_count,
                                              FrameBytes(create_options.options)),
                              reservation.ok() ? *std::move(reservation) : Quotas::Reservation()});
  }
  return all;
}

absl::StatusOr<std::shared_ptr<PoolSession>> PoolSupervisor::FindForStream(
    absl::string_view owner, absl::string_view name) const {
  if (draining_) {
    return Draining();
  }
  return pools_.Find(owner, name);
}

absl::Status PoolSupervisor::Delete(absl::string_view owner, absl::string_view name) {
  const absl::StatusOr<std::shared_ptr<PoolSession>> pool = pools_.Remove(owner, name);
  if (!pool.ok()) {
    return pool.status();
  }
  (*pool)->Close(absl::AbortedError(absl::StrCat("pool ", name, " was deleted")));
  LogEvent(LogLevel::kInfo, "pool_deleted",
           {{"pool", (*pool)->name()}, {"owner", (*pool)->owner()}});
  return absl::OkStatus();
}

absl::Time PoolSupervisor::FreeExpired(absl::Time now) {
  absl::Time next = absl::InfiniteFuture();
  for (const std::shared_ptr<PoolSession>& pool : pools_.All()) {
    if (!pool->CloseIfExpired(now)) {
      next = std::min(next, pool->expire_time());
      continue;
    }
    // It may have been deleted meanwhile and its name reused.
    if (pools_.Remove(*pool)) {
      metrics_->AddExpiredPool();
      LogEvent(LogLevel::kInfo, "lease_expired",
               {{"pool", pool->name()}, {"owner", pool->owner()}});
    }
  }
  return next;
}

absl::Status PoolSupervisor::Draining() const {
  return absl::UnavailableError(keeps_pools()
                                    ? "the server is stopping and keeps its pools; attach again "
                                      "until it is back"
                                    : "the server drains and will stop; use another server");
}

void PoolSupervisor::Drain() {
  draining_ = true;
  if (!keeps_pools()) {
    pools_.MarkLeaving();
  }
  for (const std::shared_ptr<PoolSession>& pool : pools_.All()) {
    pool->End(StreamEnd::kDrain, Draining());
    pool->EndObservers(Draining());
  }
}

Load PoolSupervisor::load() const {
  Load load;
  load.worker_count = backend_factory_->worker_count();
  load.step_count = step_count_;
  load.resume_buffer_bytes = resume_buffer_bytes_.reserved_bytes();
  load.draining = draining_;
  load.env_count = capacity_.env_count();
  for (const std::shared_ptr<PoolSession>& pool : pools_.All()) {
    load.pool_count += 1;
    load.stream_count += pool->attached() ? 1 : 0;
  }
  return load;
}

}  // namespace procgen
