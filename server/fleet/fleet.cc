#include "server/fleet/fleet.h"

#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/time.h"
#include "server/rpc/convert_pool.h"

namespace procgen {
namespace {

constexpr int32_t kSideThreadCount = 2;
// How often shards look at their nodes though nothing seems to have changed.
constexpr absl::Duration kLookInterval = absl::Seconds(1);

std::string DrawName() { return absl::StrFormat("%08x", std::random_device()()); }

std::string PrefixOf(const std::string& name) { return absl::StrCat("fleet-", name, "-"); }

}  // namespace

Fleet::Fleet(FleetOptions options, Metrics* metrics)
    : options_(std::move(options)),
      metrics_(metrics),
      name_(DrawName()),
      process_(DrawName()),
      nodes_(options_),
      leftovers_(PrefixOf(name_), &nodes_),
      side_crew_(kSideThreadCount),
      watch_([this] { Watch(); }) {}

Fleet::~Fleet() {
  {
    absl::MutexLock lock(&mutex_);
    stops_ = true;
  }
  watch_.join();
}

void Fleet::Create(const PoolOrder& order, CreateDone done) {
  side_crew_.Run([this, order, done = std::move(done)]() mutable {
    absl::StatusOr<std::unique_ptr<FleetPool>> made = Make(order);
    if (!made.ok()) {
      done(made.status());
      return;
    }
    FleetPool* const pool = made->get();
    pool->Place([pool = *std::move(made), done = std::move(done)](absl::Status status) mutable {
      if (status.ok()) {
        done(std::move(pool));
      } else {
        done(std::move(status));
      }
    });
  });
}

absl::StatusOr<std::unique_ptr<FleetPool>> Fleet::Make(const PoolOrder& order) {
  absl::StatusOr<std::unique_ptr<Pool>> model = FleetPool::Check(order.options);
  if (!model.ok()) {
    return model.status();
  }
  const auto shares = nodes_.Divide(order.options.env_count);
  if (!shares.ok()) {
    return shares.status();
  }
  int64_t number = 0;
  {
    absl::MutexLock lock(&mutex_);
    number = ++pool_number_;
  }
  ShardTerms terms;
  terms.label = order.name;
  terms.id_prefix = absl::StrCat(PrefixOf(name_), process_, "-", number, "-");
  terms.spec = PoolSpecMessageOf(order.options);
  terms.options = &options_;
  terms.nodes = &nodes_;
  terms.leftovers = &leftovers_;
  terms.metrics = metrics_;
  auto pool = std::make_unique<FleetPool>(order.options, *std::move(model), terms, *shares,
                                          &side_crew_, [this](FleetPool* gone) {
                                            absl::MutexLock lock(&mutex_);
                                            pools_.erase(gone);
                                          });
  absl::MutexLock lock(&mutex_);
  pools_.insert(pool.get());
  return pool;
}

void Fleet::OnNodesChanged() {
  {
    absl::MutexLock lock(&mutex_);
    changed_ = true;
  }
  nodes_.OnChange();
  leftovers_.OnChange();
}

void Fleet::Watch() {
  const auto awaited = [this]()
                           ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stops_ || changed_; };
  absl::MutexLock lock(&mutex_);
  while (!stops_) {
    changed_ = false;
    for (FleetPool* pool : pools_) {
      pool->Look();
    }
    mutex_.AwaitWithTimeout(absl::Condition(&awaited), kLookInterval);
  }
}

}  // namespace procgen
