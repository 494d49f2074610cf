#ifndef SERVER_CLUSTER_FLAGS_H_
#define SERVER_CLUSTER_FLAGS_H_

#include "server/config.h"

namespace procgen {

// Reads the cluster flags into `config`. REQUIRES: config->server.address is set.
void ReadClusterFlags(Config* config);

}  // namespace procgen

#endif  // SERVER_CLUSTER_FLAGS_H_
