#include "server/fleet/fleet.h"

#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/time.h"
#include "server/fleet/log/shard_request.h"
#include "server/logging/event_log.h"
#include "server/wire/convert_observation.h"
#include "server/wire/convert_pool.h"

namespace procgen {
namespace {

constexpr int32_t kBackgroundThreadCount = 2;

std::string DrawName() { return absl::StrFormat("%08x", std::random_device()()); }

std::string PrefixOf(const std::string& name) { return absl::StrCat("fleet-", name, "-"); }

}  // namespace

Fleet::Fleet(FleetOptions options, Metrics* metrics)
    : options_(std::move(options)),
      metrics_(metrics),
      name_(options_.state == nullptr ? DrawName() : options_.state->fleet_name()),
      process_(DrawName()),
      nodes_(options_),
      orphan_collector_(PrefixOf(name_), &nodes_),
      threads_(options_.shard_threads_max),
      executor_(kBackgroundThreadCount),
      watch_([this] { Watch(); }),
      subscription_(options_.subscribe([this] { OnNodesChanged(); })) {}

Fleet::~Fleet() {
  {
    absl::MutexLock lock(&mutex_);
    stops_ = true;
    wakes_.NotifyAll();
  }
  watch_.join();
}

void Fleet::Create(const CreatePoolOptions& create_options, CreateDone done) {
  executor_.Run(create_options.owner, [this, create_options = create_options,
                                       done = std::move(done)]() mutable {
    absl::StatusOr<std::unique_ptr<FleetPool>> made = Make(create_options);
    absl::StatusOr<Plan> plan =
        made.ok() ? MakePlan(create_options.options.env_count) : made.status();
    if (!plan.ok()) {
      done(plan.status());
      return;
    }
    FleetPool* const pool = made->get();
    auto finish = [this, create_options = std::move(create_options), pool = *std::move(made),
                   done = std::move(done)](absl::Status status) mutable {
      // Not on this thread, a shard's: the pool may be destroyed.
      executor_.Run(create_options.owner,
                    [this, create_options, pool = std::move(pool), status = std::move(status),
                     done = std::move(done)]() mutable {
                      if (status.ok() && options_.state != nullptr) {
                        status = Keep(create_options, options_.state->NextPath(), pool.get());
                      }
                      if (status.ok()) {
                        done(std::move(pool));
                      } else {
                        done(std::move(status));
                      }
                    });
    };
    pool->Begin(plan->assignments, std::move(plan->threads), std::move(finish));
  });
}

absl::StatusOr<Fleet::Plan> Fleet::MakePlan(int32_t env_count) {
  auto assignments = nodes_.PlanShards(env_count);
  if (!assignments.ok()) {
    return assignments.status();
  }
  auto threads = threads_.Reserve(assignments->size());
  if (!threads.ok()) {
    return threads.status();
  }
  if (threads->size() < assignments->size()) {
    assignments = nodes_.PlanShards(env_count, threads->size());
    if (!assignments.ok()) {
      return assignments.status();
    }
  }
  return Plan{*std::move(assignments), *std::move(threads)};
}

absl::StatusOr<std::unique_ptr<FleetPool>> Fleet::Make(const CreatePoolOptions& create_options) {
  absl::StatusOr<StateValidator> validator = StateValidator::Create(create_options.options);
  if (!validator.ok()) {
    return validator.status();
  }
  int64_t number = 0;
  {
    absl::MutexLock lock(&mutex_);
    number = ++pool_number_;
  }
  ShardContext context;
  context.owner = create_options.owner;
  context.label = create_options.name;
  context.id_prefix = absl::StrCat(PrefixOf(name_), process_, "-", number, "-");
  context.spec = PoolSpecMessageOf(create_options.options);
  context.options = &options_;
  context.nodes = &nodes_;
  context.orphan_collector = &orphan_collector_;
  context.threads = &threads_;
  context.metrics = metrics_;
  context.answers_kept = options_.state == nullptr ? 0 : options_.requests_in_flight_max;
  auto pool = std::make_unique<FleetPool>(create_options.options, *std::move(validator), context,
                                          &executor_, [this](FleetPool* gone) {
                                            absl::MutexLock lock(&mutex_);
                                            pools_.erase(gone);
                                          });
  absl::MutexLock lock(&mutex_);
  pools_.insert(pool.get());
  return pool;
}

absl::Status Fleet::Keep(const CreatePoolOptions& create_options, const std::string& path,
                         FleetPool* pool) {
  v1::Pool message;
  message.set_owner(create_options.owner);
  message.set_name(create_options.name);
  v1::PoolSpec* const spec = message.mutable_spec();
  *spec = PoolSpecMessageOf(create_options.options);
  if (create_options.options.level_sampler != nullptr) {
    *spec->mutable_level_sampler() = LevelSamplerMessageOf(*create_options.options.level_sampler);
  }
  spec->set_encoding(EncodingMessageOf(create_options.session_options.encoding));
  spec->set_transport(create_options.session_options.shares_memory ? v1::TRANSPORT_SHARED_MEMORY
                                                                   : v1::TRANSPORT_STREAM);
  if (create_options.session_options.lease_duration != absl::InfiniteDuration()) {
    *spec->mutable_lease_duration() =
        DurationMessageOf(create_options.session_options.lease_duration);
  }
  return pool->KeepIn(path, message);
}

std::vector<ResumedPool> Fleet::TakeResumed() {
  std::vector<ResumedPool> all;
  if (options_.state == nullptr) {
    return all;
  }
  for (const FleetState::Left& left : options_.state->TakeLeft()) {
    absl::StatusOr<ResumedPool> resumed = Resume(left);
    if (!resumed.ok()) {
      LogEvent(LogLevel::kError, "pool_resume_failed",
               {{"file", left.path}, {"message", std::string(resumed.status().message())}});
      continue;
    }
    LogEvent(LogLevel::kInfo, "pool_resumed",
             {{"pool", resumed->create_options.name},
              {"owner", resumed->create_options.owner},
              {"next_sequence_number", absl::StrCat(resumed->next_sequence_number)}});
    all.push_back(*std::move(resumed));
  }
  return all;
}

absl::StatusOr<ResumedPool> Fleet::Resume(const FleetState::Left& left) {
  const v1::Pool& message = left.pool.pool;
  absl::StatusOr<PoolOptions> options = PoolOptionsOf(message.spec());
  const absl::StatusOr<Encoding> encoding = EncodingOf(message.spec());
  if (!options.ok() || !encoding.ok()) {
    return options.ok() ? encoding.status() : options.status();
  }
  ResumedPool resumed;
  resumed.create_options = {message.owner(), message.name(), *std::move(options), {}};
  SessionOptions& session_options = resumed.create_options.session_options;
  session_options.encoding = *encoding;
  session_options.shares_memory = message.spec().transport() == v1::TRANSPORT_SHARED_MEMORY;
  if (message.spec().has_lease_duration()) {
    session_options.lease_duration = absl::Seconds(message.spec().lease_duration().seconds()) +
                                     absl::Nanoseconds(message.spec().lease_duration().nanos());
  }
  absl::StatusOr<std::unique_ptr<FleetPool>> pool = Make(resumed.create_options);
  if (!pool.ok()) {
    return pool.status();
  }
  // A learner cannot map the shared memory of an earlier process.
  const int64_t answer_count = session_options.shares_memory ? 0 : options_.requests_in_flight_max;
  const auto requests = (*pool)->Resume(left.path, left.pool, answer_count);
  if (!requests.ok()) {
    return requests.status();
  }
  for (const v1::StepPoolRequest& request : *requests) {
    resumed.requests.push_back(request.SerializeAsString());
  }
  resumed.next_sequence_number = left.pool.next_sequence_number();
  resumed.pool = *std::move(pool);
  return resumed;
}

void Fleet::OnNodesChanged() {
  {
    absl::MutexLock lock(&mutex_);
    changed_ = true;
    wakes_.NotifyAll();
  }
  nodes_.OnNodesChanged();
  orphan_collector_.OnNodesChanged();
}

void Fleet::Watch() {
  absl::MutexLock lock(&mutex_);
  while (!stops_) {
    changed_ = false;
    // Connects to new nodes, so that pools can be rebalanced onto them.
    orphan_collector_.OnNodesChanged();
    for (FleetPool* pool : pools_) {
      pool->OnNodesChanged();
    }
    wakes_.AwaitUntil(&mutex_, SteadyNow() + options_.poll_interval,
                      [this]()
                          ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stops_ || changed_; });
  }
}

}  // namespace procgen
