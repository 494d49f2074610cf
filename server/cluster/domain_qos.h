#ifndef SERVER_CLUSTER_DOMAIN_QOS_H_
#define SERVER_CLUSTER_DOMAIN_QOS_H_

#include "server/cluster/cluster_options.h"
#include "server/cluster/dds_entity.h"

namespace procgen {

// Quality-of-service settings of a node; README.md gives the reasons.

DdsQos ParticipantQos(const ClusterOptions& options);
// Of publisher and subscriber: the partition is the cluster's name.
DdsQos PartitionQos(const ClusterOptions& options);
// Of topics, their writers and readers.
DdsQos StatusQos();
DdsQos RatesQos();

}  // namespace procgen

#endif  // SERVER_CLUSTER_DOMAIN_QOS_H_
