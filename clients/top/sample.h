#ifndef CLIENTS_TOP_SAMPLE_H_
#define CLIENTS_TOP_SAMPLE_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/cluster.pb.h"
#include "procgen/v1/pools.pb.h"
#include "procgen_client/client.h"

namespace procgen_top {

// How a server stands at a moment. Rates are the differences of two of them.
struct Sample {
  absl::Time time;
  procgen::v1::Load load;
  procgen::v1::ListNodesResponse nodes;  // of its cluster; none: it is too old to tell
  std::vector<procgen::v1::Pool> pools;  // that the caller owns
};

// Asks the server. Errors: the server's.
absl::StatusOr<Sample> TakeSample(procgen_client::Client* client);

}  // namespace procgen_top

#endif  // CLIENTS_TOP_SAMPLE_H_
