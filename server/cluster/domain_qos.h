#ifndef SERVER_CLUSTER_DOMAIN_QOS_H_
#define SERVER_CLUSTER_DOMAIN_QOS_H_

#include <string>

#include "server/cluster/dds_entity.h"

namespace procgen {

// Quality-of-service settings of a node; README.md gives the reasons.

// Of publishers and subscribers.
DdsQos PartitionQos(const std::string& name);
// Of the topic, its writer and its reader.
DdsQos StatusQos();

}  // namespace procgen

#endif  // SERVER_CLUSTER_DOMAIN_QOS_H_
