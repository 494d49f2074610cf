#include "server/metrics/metrics_page.h"

#include <exception>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "prometheus/exposer.h"

namespace procgen {
namespace {

// An incomplete request occupies a thread until its timeout.
constexpr char kThreadCount[] = "8";
constexpr char kTimeoutMs[] = "1000";

}  // namespace

absl::StatusOr<std::unique_ptr<MetricsPage>> MetricsPage::Start(const std::string& address,
                                                                const Metrics& metrics) {
  std::unique_ptr<prometheus::Exposer> exposer;
  try {
    exposer = std::make_unique<prometheus::Exposer>(std::vector<std::string>{
        "listening_ports", address, "num_threads", kThreadCount, "request_timeout_ms", kTimeoutMs});
  } catch (const std::exception& error) {  // thrown if it cannot listen
    return absl::UnavailableError(
        absl::StrCat("metrics cannot be served at ", address, ": ", error.what()));
  }
  exposer->RegisterCollectable(metrics.collectable());
  std::string bound = absl::StrCat(address.substr(0, address.rfind(':')), ":",
                                   exposer->GetListeningPorts().front());
  return std::unique_ptr<MetricsPage>(new MetricsPage(std::move(bound), std::move(exposer)));
}

MetricsPage::MetricsPage(std::string address, std::unique_ptr<prometheus::Exposer> exposer)
    : address_(std::move(address)), exposer_(std::move(exposer)) {}

MetricsPage::~MetricsPage() = default;

}  // namespace procgen
