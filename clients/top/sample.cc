#include "clients/top/sample.h"

#include <utility>

#include "absl/time/clock.h"

namespace procgen_top {

namespace v1 = procgen::v1;

absl::StatusOr<Sample> TakeSample(procgen_client::Client* client) {
  absl::StatusOr<std::vector<v1::Pool>> pools = client->ListPools();
  if (!pools.ok()) {
    return pools.status();
  }
  absl::StatusOr<v1::Load> load = client->GetLoad();
  if (!load.ok()) {
    return load.status();
  }
  absl::StatusOr<v1::ListNodesResponse> nodes = client->ListNodes();
  if (!nodes.ok() && !absl::IsUnimplemented(nodes.status())) {
    return nodes.status();
  }
  return Sample{absl::Now(), *std::move(load),
                nodes.ok() ? *std::move(nodes) : v1::ListNodesResponse(), *std::move(pools)};
}

}  // namespace procgen_top
