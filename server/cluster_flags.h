#ifndef SERVER_CLUSTER_FLAGS_H_
#define SERVER_CLUSTER_FLAGS_H_

#include "server/config.h"

namespace procgen {

// Puts into `config` what the flags say of the cluster, and of where this server is in it. Its
// address must be in it already.
void ReadClusterFlags(Config* config);

}  // namespace procgen

#endif  // SERVER_CLUSTER_FLAGS_H_
