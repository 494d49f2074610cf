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

// Serves metrics over HTTP at http://HOST:PORT/metrics, on its own threads.
// Threads: any method from any thread.
class MetricsPage {
 public:
  // Listens on `address`: "HOST:PORT", IPv4 only; port 0: any free port. `metrics` must outlive
  // this. Errors: UNAVAILABLE it cannot listen on the address.
  static absl::StatusOr<std::unique_ptr<MetricsPage>> Start(const std::string& address,
                                                            const Metrics& metrics);
  ~MetricsPage();
  MetricsPage(const MetricsPage&) = delete;
  MetricsPage& operator=(const MetricsPage&) = delete;

  // The listening address, with the bound port.
  const std::string& address() const { return address_; }

 private:
  MetricsPage(std::string address, std::unique_ptr<prometheus::Exposer> exposer);

  const std::string address_;
  const std::unique_ptr<prometheus::Exposer> exposer_;
};

}  // namespace procgen

#endif  // SERVER_METRICS_METRICS_PAGE_H_
