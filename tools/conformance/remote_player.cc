#include <utility>

#include "procgen_client/servers.h"
#include "tools/conformance/player.h"

namespace procgen {
namespace {

class RemotePlayer final : public Player {
 public:
  RemotePlayer(std::unique_ptr<procgen_client::Pool> pool, bool with_pictures)
      : pool_(std::move(pool)), with_pictures_(with_pictures) {}

  absl::Status Observe(Observations* observed) override {
    return pool_->Step({.count = env_count(), .steps = false}, {}, Arrays(observed));
  }

  absl::Status Step(absl::Span<const int32_t> actions, Observations* observed) override {
    return pool_->Step({.count = env_count(), .actions = actions}, {}, Arrays(observed));
  }

 private:
  int32_t env_count() const { return pool_->options().env_count; }
  Batch Arrays(Observations* observed) const {
    return BatchOf(observed, env_count(), with_pictures_);
  }

  const std::unique_ptr<procgen_client::Pool> pool_;
  const bool with_pictures_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Player>> MakeRemotePlayer(const Trace& trace,
                                                         const std::string& addresses,
                                                         bool with_pictures) {
  const auto servers = procgen_client::Servers::Connect(addresses);
  if (!servers.ok()) {
    return servers.status();
  }
  auto pool = procgen_client::CreatePool(*servers, PoolOptionsOf(trace));
  if (!pool.ok()) {
    return pool.status();
  }
  return std::make_unique<RemotePlayer>(*std::move(pool), with_pictures);
}

}  // namespace procgen
