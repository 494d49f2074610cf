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

// State of a server at one time. Rates are differences of two samples.
struct Sample {
  absl::Time time;
  procgen::v1::Load load;
  procgen::v1::ListNodesResponse
      nodes;  // of its cluster; empty for a server without ClusterService
  std::vector<procgen::v1::Pool> pools;  // the caller's
};

// Gets a sample from the server. Errors: those of the server.
absl::StatusOr<Sample> TakeSample(procgen_client::Client* client);

}  // namespace procgen_top

#endif  // CLIENTS_TOP_SAMPLE_H_
