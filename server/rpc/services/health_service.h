#ifndef SERVER_RPC_SERVICES_HEALTH_SERVICE_H_
#define SERVER_RPC_SERVICES_HEALTH_SERVICE_H_

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "grpc/health/v1/health.pb.h"
#include "server/rpc/auth/call_accounting.h"
#include "server/rpc/call/byte_service.h"
#include "server/rpc/watch/latest_stream.h"

namespace procgen {

// grpc.health.v1.Health: the serving status of the server and of each service. gRPC's own
// implementation is not used because it does not limit its calls.
// Threads: any method from any thread.
class HealthServiceImpl final : public ByteService {
 public:
  using Status = grpc::health::v1::HealthCheckResponse::ServingStatus;

  // `services`: names of the services, besides "" for the server. Initially none is serving.
  // `accounting` must outlive this.
  HealthServiceImpl(const CallAccounting* accounting, std::set<std::string> services);

  // Sets the status of all services and sends it to all watches.
  void SetServing(bool is_serving) ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends all streams of Watch.
  void EndWatches() ABSL_LOCKS_EXCLUDED(mutex_);

  // Returns SERVICE_UNKNOWN for an unknown service.
  Status StatusOf(const std::string& service) const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  class Watch;

  ByteStream* BeginCheck();
  ByteStream* BeginWatch() ABSL_LOCKS_EXCLUDED(mutex_);
  std::vector<std::shared_ptr<Watch>> Watches() const ABSL_LOCKS_EXCLUDED(mutex_);

  const CallAccounting* const accounting_;
  std::set<std::string> services_;
  mutable absl::Mutex mutex_;
  bool is_serving_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::weak_ptr<Watch>> watches_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_HEALTH_SERVICE_H_
