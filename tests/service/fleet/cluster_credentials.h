#ifndef TESTS_SERVICE_FLEET_CLUSTER_CREDENTIALS_H_
#define TESTS_SERVICE_FLEET_CLUSTER_CREDENTIALS_H_

#include <string>

#include "server/cluster/cluster_options.h"
#include "tests/service/security/certificates.h"

namespace procgen {

// DDS Security credentials for nodes of a cluster, made by openssl from the files in
// server/cluster/security, as its README.md describes. The destructor removes them.
class ClusterCredentials {
 public:
  // Creates a certificate authority that signs nodes of `cluster`.
  explicit ClusterCredentials(const std::string& cluster);

  ClusterSecurity security() const;

 private:
  const Certificates files_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_FLEET_CLUSTER_CREDENTIALS_H_
