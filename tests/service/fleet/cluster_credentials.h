#ifndef TESTS_SERVICE_FLEET_CLUSTER_CREDENTIALS_H_
#define TESTS_SERVICE_FLEET_CLUSTER_CREDENTIALS_H_

#include <string>

#include "server/cluster/cluster_options.h"
#include "tests/service/security/certificates.h"

namespace procgen {

// What nodes of a cluster with DDS Security show to each other, made by openssl out of the files in
// server/cluster/security as its README says. Gone with this.
class ClusterCredentials {
 public:
  // A certificate authority of its own, which vouches for nodes of the cluster `cluster`.
  explicit ClusterCredentials(const std::string& cluster);

  ClusterSecurity security() const;

 private:
  const Certificates files_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_FLEET_CLUSTER_CREDENTIALS_H_
