#ifndef SERVER_METRICS_METRICS_PAGE_H_
#define SERVER_METRICS_METRICS_PAGE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/metrics/metrics.h"

namespace prometheus {
class Exposer;
}  // namespace prometheus

namespace procgen {

// Serves metrics over HTTP, at http://HOST:PORT/metrics, in threads of its own. Threads: any method
// from any thread.
class MetricsPage {
 public:
  // Listens at `address`, "host:port" of IPv4; port 0: any that is free. `metrics` must
  // outlive this. Errors: UNAVAILABLE the address cannot be listened on.
  static absl::StatusOr<std::unique_ptr<MetricsPage>> Start(const std::string& address,
                                                            const Metrics& metrics);
  ~MetricsPage();
  MetricsPage(const MetricsPage&) = delete;
  MetricsPage& operator=(const MetricsPage&) = delete;

  // Where it listens, with the port that was bound.
  const std::string& address() const { return address_; }

 private:
  MetricsPage(std::string address, std::unique_ptr<prometheus::Exposer> exposer);

  const std::string address_;
  const std::unique_ptr<prometheus::Exposer> exposer_;
};

}  // namespace procgen

#endif  // SERVER_METRICS_METRICS_PAGE_H_
