#ifndef CLIENTS_TOP_NODE_TABLE_H_
#define CLIENTS_TOP_NODE_TABLE_H_

#include <string>
#include <vector>

#include "procgen/v1/cluster.pb.h"

namespace procgen_top {

// Formats the servers of a cluster as lines of text without control characters; the local node has
// a star. Empty without a cluster.
std::vector<std::string> NodeTableOf(const procgen::v1::ListNodesResponse& cluster);

}  // namespace procgen_top

#endif  // CLIENTS_TOP_NODE_TABLE_H_
