#ifndef SERVER_CLUSTER_DOMAIN_QOS_H_
#define SERVER_CLUSTER_DOMAIN_QOS_H_

#include "server/cluster/cluster_options.h"
#include "server/cluster/dds_entity.h"

namespace procgen {

// How the parts of a node in the domain speak: README.md tells why.

DdsQos ParticipantQos(const ClusterOptions& options);
// Of what the node publishes and subscribes to: the cluster's name is the partition.
DdsQos PartitionQos(const ClusterOptions& options);
// Of topics, with their writers and readers.
DdsQos StatusQos();
DdsQos RatesQos();

}  // namespace procgen

#endif  // SERVER_CLUSTER_DOMAIN_QOS_H_
