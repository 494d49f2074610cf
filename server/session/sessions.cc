#include "server/session/sessions.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "server/logging/event_log.h"
#include "server/session/host/local_pool.h"

namespace procgen {
namespace {

constexpr int32_t kBackgroundThreadCount = 2;
constexpr size_t kPoolIdLengthMax = 63;
constexpr absl::string_view kNamePrefix = "pools/";

bool IsPoolId(absl::string_view id, bool leading_digit_allowed) {
  if (id.empty() || id.size() > kPoolIdLengthMax || id.back() == '-') {
    return false;
  }
  const bool starts_well =
      absl::ascii_islower(static_cast<unsigned char>(id.front())) ||
      (leading_digit_allowed && absl::ascii_isdigit(static_cast<unsigned char>(id.front())));
  return starts_well && std::all_of(id.begin(), id.end(), [](unsigned char letter) {
           return absl::ascii_islower(letter) || absl::ascii_isdigit(letter) || letter == '-';
         });
}

absl::Status CheckName(absl::string_view name) {
  absl::string_view id = name;
  if (!absl::ConsumePrefix(&id, kNamePrefix) || !IsPoolId(id, true)) {
    return absl::InvalidArgumentError(
        absl::StrCat("pool name is '", name.substr(0, 2 * kPoolIdLengthMax),
                     "', allowed: 'pools/ID', with an ID of 1 to 63 of a-z, 0-9 and '-'"));
  }
  return absl::OkStatus();
}

absl::Status CheckEnvCount(int32_t env_count, int32_t environment_count, const Limits& limits) {
  if (env_count < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "spec.env_count is ", env_count, ", allowed: 1 to ", limits.pool_environment_count_max));
  }
  if (env_count > limits.pool_environment_count_max) {
    return absl::ResourceExhaustedError(absl::StrCat("spec.env_count is ", env_count,
                                                     ", limit pool_environment_count_max is ",
                                                     limits.pool_environment_count_max));
  }
  if (env_count > limits.environment_count_max - environment_count) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "spec.env_count is ", env_count, " and there are ", environment_count,
        " environments, limit environment_count_max is ", limits.environment_count_max));
  }
  return absl::OkStatus();
}

// One observation of each environment, in bytes. REQUIRES: CheckEnvCount.
int64_t ObservationBytesOf(const PoolOptions& options) {
  return options.env_count * static_cast<int64_t>(options.observation_format.bytes());
}

absl::Status CheckObservationBytes(int64_t bytes, int64_t bytes_of_others, const Limits& limits) {
  if (bytes > limits.observation_bytes_max - bytes_of_others) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "one observation of each environment takes ", bytes, " bytes and those of other pools ",
        bytes_of_others, ", limit observation_bytes_max is ", limits.observation_bytes_max));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckLeaseDuration(absl::string_view field, absl::Duration lease_duration,
                                const Limits& limits) {
  if (lease_duration < kLeaseDurationMin) {
    return absl::InvalidArgumentError(
        absl::StrCat(field, " is ", absl::FormatDuration(lease_duration),
                     ", allowed: ", absl::FormatDuration(kLeaseDurationMin), " to ",
                     absl::FormatDuration(limits.lease_duration_max)));
  }
  if (lease_duration > limits.lease_duration_max) {
    return absl::ResourceExhaustedError(absl::StrCat(
        field, " is ", absl::FormatDuration(lease_duration), ", limit lease_duration_max is ",
        absl::FormatDuration(limits.lease_duration_max)));
  }
  return absl::OkStatus();
}

Sessions::Sessions(const Limits& limits, int32_t worker_count, Metrics* metrics,
                   std::shared_ptr<const SharedArt> art, Clock clock,
                   std::shared_ptr<const SharedFolder> shared_folder,
                   std::unique_ptr<PoolHost> host)
    : limits_(limits),
      metrics_(metrics),
      art_(std::move(art)),
      owners_(limits, [this] { memory_trimmer_.Request(); }),
      kept_answer_bytes_(limits.kept_answer_bytes_max),
      shared_memory_bytes_(limits.shared_memory_bytes_max),
      episode_bytes_(limits.episode_bytes_max),
      shared_folder_(std::move(shared_folder)),
      executor_(kBackgroundThreadCount),
      host_(host != nullptr ? std::move(host)
                            : std::make_unique<LocalPoolHost>(worker_count, art_, &executor_)),
      lease_alarm_(std::move(clock), [this](absl::Time now) { return FreeExpired(now); }) {}

Sessions::~Sessions() {
  std::vector<std::shared_ptr<PoolSession>> pools;
  {
    absl::MutexLock lock(&mutex_);
    pools = All();
    entries_.clear();
  }
  pools.clear();
  const auto all_freed = [this]()
                             ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return unfreed_count_ == 0; };
  absl::MutexLock lock(&mutex_, absl::Condition(&all_freed));
}

void Sessions::Create(absl::string_view owner, absl::string_view id, const PoolOptions& options,
                      const PoolTerms& terms, CreateDone done) {
  absl::StatusOr<Key> key = Reserve(owner, id, options);
  if (!key.ok()) {
    done(key.status());
    return;
  }
  const PoolOrder order = {key->first, key->second, options, terms};
  host_->Create(order, [this, key = *std::move(key), terms, done = std::move(done)](
                           absl::StatusOr<std::unique_ptr<HostedPool>> pool) mutable {
    Finish(key, std::move(pool), terms, std::move(done));
  });
}

absl::StatusOr<Sessions::Key> Sessions::Reserve(absl::string_view owner, absl::string_view id,
                                                const PoolOptions& options) {
  if (!id.empty() && !IsPoolId(id, false)) {
    return absl::InvalidArgumentError(
        absl::StrCat("pool_id is '", id.substr(0, 2 * kPoolIdLengthMax),
                     "', allowed: 1 to 63 of a-z, 0-9 and '-', beginning with a letter and not "
                     "ending in '-'"));
  }
  absl::MutexLock lock(&mutex_);
  if (draining_) {
    return Draining();
  }
  if (absl::Status status = CheckEnvCount(options.env_count, environment_count_, limits_);
      !status.ok()) {
    return status;
  }
  const int64_t observation_bytes = ObservationBytesOf(options);
  if (absl::Status status = CheckObservationBytes(observation_bytes, observation_bytes_, limits_);
      !status.ok()) {
    return status;
  }
  if (entries_.size() >= static_cast<size_t>(limits_.pool_count_max)) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "there are ", entries_.size(), " pools, limit pool_count_max is ", limits_.pool_count_max));
  }
  absl::StatusOr<Owners::Share> share =
      owners_.Take(owner, {.pool_count = 1, .environment_count = options.env_count});
  if (!share.ok()) {
    return share.status();
  }
  const int64_t number = next_number_;
  std::string name = id.empty() ? absl::StrCat(kNamePrefix, number) : absl::StrCat(kNamePrefix, id);
  Key key(owner, std::move(name));
  Entry entry = {number, options.env_count, observation_bytes, *std::move(share), false, nullptr};
  if (!entries_.try_emplace(key, std::move(entry)).second) {
    return absl::AlreadyExistsError(
        absl::StrCat("pool ", key.second, " exists; choose another pool_id"));
  }
  next_number_ = number + 1;
  environment_count_ += options.env_count;
  observation_bytes_ += observation_bytes;
  return key;
}

void Sessions::EraseLocked(const Key& key) {
  const auto entry = entries_.find(key);
  environment_count_ -= entry->second.env_count;
  observation_bytes_ -= entry->second.observation_bytes;
  entries_.erase(entry);
}

void Sessions::Finish(const Key& key, absl::StatusOr<std::unique_ptr<HostedPool>> pool,
                      const PoolTerms& terms, CreateDone done) {
  if (!pool.ok()) {
    {
      absl::MutexLock lock(&mutex_);
      EraseLocked(key);
    }
    done(pool.status());
    return;
  }
  const PoolOrder order = {key.first, key.second, (*pool)->options(), terms};
  std::shared_ptr<PoolSession> session = MakeSession(order, *std::move(pool));
  {
    absl::MutexLock lock(&mutex_);
    entries_.find(key)->second.pool = session;
  }
  LogEvent(LogLevel::kInfo, "pool_created",
           {{"pool", session->name()},
            {"owner", session->owner()},
            {"games", session->options().games.front()},
            {"environments", absl::StrCat(session->env_count())}});
  done(std::move(session));
}

std::shared_ptr<PoolSession> Sessions::MakeSession(const PoolOrder& order,
                                                   std::unique_ptr<HostedPool> pool) {
  {
    absl::MutexLock lock(&mutex_);
    ++unfreed_count_;
  }
  const PoolTerms& terms = order.terms;
  // Shared by the registry and by who uses it at the moment; freed on the background executor,
  // because the last to let go may be a worker, which the pool's crew cannot do without.
  return {new PoolSession(order.owner, order.name, std::move(pool), terms.lease_duration,
                          {&owners_, &executor_, &lease_alarm_, &kept_answer_bytes_,
                           &shared_memory_bytes_, &episode_bytes_, &step_count_, metrics_},
                          terms.encoding, terms.shares_memory ? shared_folder_.get() : nullptr),
          [this](PoolSession* freed) {
            executor_.Run(freed->owner(), [this, freed] {
              delete freed;
              memory_trimmer_.Request();
              absl::MutexLock lock(&mutex_);
              --unfreed_count_;
            });
          }};
}

std::vector<Sessions::Resumed> Sessions::Resume() {
  std::vector<Resumed> all;
  for (ResumedPool& resumed : host_->TakeResumed()) {
    const PoolOrder& order = resumed.order;
    Resumed session = {MakeSession(order, std::move(resumed.pool)), std::move(resumed.requests)};
    session.pool->ResumeAt(resumed.next_sequence_number);
    absl::StatusOr<Owners::Share> share =
        owners_.Take(order.owner, {.pool_count = 1, .environment_count = order.options.env_count});
    all.push_back(session);
    const int64_t observation_bytes = ObservationBytesOf(order.options);
    absl::MutexLock lock(&mutex_);
    Entry entry = {next_number_++,
                   order.options.env_count,
                   observation_bytes,
                   share.ok() ? *std::move(share) : Owners::Share(),
                   false,
                   session.pool};
    environment_count_ += entry.env_count;
    observation_bytes_ += observation_bytes;
    // Numbered pools that come get no name that is taken.
    int64_t named = 0;
    if (absl::SimpleAtoi(absl::StripPrefix(order.name, kNamePrefix), &named)) {
      next_number_ = std::max(next_number_, named + 1);
    }
    entries_.insert_or_assign(Key(order.owner, order.name), std::move(entry));
  }
  return all;
}

absl::StatusOr<std::shared_ptr<PoolSession>> Sessions::FindLocked(absl::string_view owner,
                                                                  absl::string_view name) const {
  if (absl::Status status = CheckName(name); !status.ok()) {
    return status;
  }
  const auto entry = entries_.find(Key(owner, name));
  if (entry == entries_.end() || entry->second.pool == nullptr) {
    return absl::NotFoundError(absl::StrCat("there is no pool ", name));
  }
  return entry->second.pool;
}

absl::StatusOr<std::shared_ptr<PoolSession>> Sessions::Find(absl::string_view owner,
                                                            absl::string_view name) const {
  absl::MutexLock lock(&mutex_);
  return FindLocked(owner, name);
}

absl::StatusOr<std::shared_ptr<PoolSession>> Sessions::FindForStream(absl::string_view owner,
                                                                     absl::string_view name) const {
  absl::MutexLock lock(&mutex_);
  if (draining_) {
    return Draining();
  }
  return FindLocked(owner, name);
}

std::vector<Sessions::Numbered> Sessions::List(absl::string_view owner, int64_t after,
                                               size_t count) const {
  std::vector<Numbered> listed;
  {
    absl::MutexLock lock(&mutex_);
    for (auto it = entries_.lower_bound(Key(owner, ""));
         it != entries_.end() && it->first.first == owner; ++it) {
      const Entry& entry = it->second;
      if (entry.pool != nullptr && entry.number > after) {
        listed.push_back({entry.number, entry.pool});
      }
    }
  }
  std::sort(listed.begin(), listed.end(),
            [](const Numbered& left, const Numbered& right) { return left.number < right.number; });
  if (listed.size() > count) {
    listed.resize(count);
  }
  return listed;
}

std::vector<std::shared_ptr<PoolSession>> Sessions::ListAll() const {
  std::vector<std::shared_ptr<PoolSession>> pools;
  absl::MutexLock lock(&mutex_);
  for (const auto& [key, entry] : entries_) {
    if (entry.pool != nullptr) {
      pools.push_back(entry.pool);
    }
  }
  return pools;
}

absl::Status Sessions::Delete(absl::string_view owner, absl::string_view name) {
  std::shared_ptr<PoolSession> pool;
  {
    absl::MutexLock lock(&mutex_);
    absl::StatusOr<std::shared_ptr<PoolSession>> found = FindLocked(owner, name);
    if (!found.ok()) {
      return found.status();
    }
    pool = *std::move(found);
    EraseLocked(Key(owner, name));
  }
  pool->Close(absl::AbortedError(absl::StrCat("pool ", name, " was deleted")));
  LogEvent(LogLevel::kInfo, "pool_deleted", {{"pool", pool->name()}, {"owner", pool->owner()}});
  return absl::OkStatus();
}

absl::Time Sessions::FreeExpired(absl::Time now) {
  std::vector<std::shared_ptr<PoolSession>> pools;
  {
    absl::MutexLock lock(&mutex_);
    pools = All();
  }
  absl::Time next = absl::InfiniteFuture();
  for (const std::shared_ptr<PoolSession>& pool : pools) {
    if (!pool->CloseIfExpired(now)) {
      next = std::min(next, pool->expire_time());
      continue;
    }
    absl::MutexLock lock(&mutex_);
    // It may have been deleted in the meantime, and its name have gone to another.
    const Key key(pool->owner(), pool->name());
    const auto entry = entries_.find(key);
    if (entry != entries_.end() && entry->second.pool == pool) {
      EraseLocked(key);
      metrics_->AddExpiredPool();
      LogEvent(LogLevel::kInfo, "lease_ran_out",
               {{"pool", pool->name()}, {"owner", pool->owner()}});
    }
  }
  return next;
}

absl::Status Sessions::Draining() const {
  return absl::UnavailableError(keeps_pools()
                                    ? "the server stops and keeps its pools; attach again until "
                                      "it is back"
                                    : "the server drains and will stop; go on elsewhere");
}

bool Sessions::draining() const {
  absl::MutexLock lock(&mutex_);
  return draining_;
}

void Sessions::Drain() {
  std::vector<std::shared_ptr<PoolSession>> pools;
  {
    absl::MutexLock lock(&mutex_);
    draining_ = true;
    pools = All();
    for (auto& [key, entry] : entries_) {
      entry.leaving =
          entry.leaving || (entry.pool != nullptr && entry.pool->attached() && !keeps_pools());
    }
  }
  for (const std::shared_ptr<PoolSession>& pool : pools) {
    pool->End(StreamEnd::kDrain, Draining());
    pool->EndTaps(Draining());
  }
}

int32_t Sessions::LeavingCount() const {
  absl::MutexLock lock(&mutex_);
  return static_cast<int32_t>(std::count_if(entries_.begin(), entries_.end(),
                                            [](const auto& kept) { return kept.second.leaving; }));
}

std::vector<std::shared_ptr<PoolSession>> Sessions::All() const {
  std::vector<std::shared_ptr<PoolSession>> pools;
  pools.reserve(entries_.size());
  for (const auto& [key, entry] : entries_) {
    if (entry.pool != nullptr) {
      pools.push_back(entry.pool);
    }
  }
  return pools;
}

Load Sessions::load() const {
  Load load;
  load.worker_count = host_->worker_count();
  load.step_count = step_count_;
  load.kept_answer_bytes = kept_answer_bytes_.reserved_bytes();
  absl::MutexLock lock(&mutex_);
  load.draining = draining_;
  load.environment_count = environment_count_;
  for (const std::shared_ptr<PoolSession>& pool : All()) {
    load.pool_count += 1;
    load.stream_count += pool->attached() ? 1 : 0;
  }
  return load;
}

}  // namespace procgen
