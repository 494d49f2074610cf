#ifndef TESTS_SERVER_CLUSTER_PUBLISHER_H_
#define TESTS_SERVER_CLUSTER_PUBLISHER_H_

#include <thread>
#include <utility>

#include "absl/time/time.h"
#include "server/cluster/cluster.h"
#include "server/concurrency/steady_time.h"

namespace procgen {

// Publishes a status repeatedly, as a server does, until it is destroyed.
class Publisher {
 public:
  // `cluster` must outlive this object.
  Publisher(Cluster* cluster, NodeStatus status) {
    cluster->Publish(status);
    thread_ = std::thread([this, cluster, status = std::move(status)] {
      while (!stopped_.WaitWithTimeout(absl::Milliseconds(500))) {
        cluster->Publish(status);
      }
    });
  }
  ~Publisher() {
    stopped_.Notify();
    thread_.join();
  }
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

 private:
  SteadyNotification stopped_;
  std::thread thread_;
};

}  // namespace procgen

#endif  // TESTS_SERVER_CLUSTER_PUBLISHER_H_
