#ifndef SERVER_CLUSTER_DOMAIN_QOS_H_
#define SERVER_CLUSTER_DOMAIN_QOS_H_

#include <string>
#include <vector>

#include "server/cluster/dds_entity.h"

namespace procgen {

// Quality-of-service settings of a node; README.md gives the reasons.

// Of publishers and subscribers.
DdsQos PartitionQos(const std::vector<std::string>& names);
// Of topics, their writers and readers.
DdsQos StatusQos();
DdsQos HeartbeatQos();

}  // namespace procgen

#endif  // SERVER_CLUSTER_DOMAIN_QOS_H_
