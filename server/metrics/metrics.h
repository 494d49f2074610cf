#ifndef SERVER_METRICS_METRICS_H_
#define SERVER_METRICS_METRICS_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/metrics/atomic_histogram.h"

namespace prometheus {
class Collectable;
}  // namespace prometheus

namespace procgen {

// The values of a server's gauges when its metrics are read.
struct ServerGauges {
  int32_t pool_count = 0;
  int32_t env_count = 0;
  int32_t worker_count = 0;
  bool draining = false;
};

// Totals of all streams since the start, for the API's Load message.
struct StreamTotals {
  int64_t received_bytes = 0;
  int64_t sent_bytes = 0;
  HistogramCounts queue_seconds;
  HistogramCounts run_seconds;
};

// Counters of one game in one mode, over all pools.
// Threads: any method from any thread; none allocates or blocks.
class GameMetrics {
 public:
  virtual ~GameMetrics() = default;

  virtual void AddSteps(int64_t count) = 0;
  virtual void AddEpisode(float episode_return, int32_t steps) = 0;
};

// The metrics of a server, in Prometheus' format; README.md lists them.
// Threads: any method from any thread. The methods that run for each request of a stream
// (AddRequest, AddReceivedBytes, AddSentBytes) neither allocate nor block.
class Metrics {
 public:
  explicit Metrics(absl::string_view version);
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  // Sets the function that returns the gauges. It is called whenever the metrics are read, must not
  // block for long, and must be valid as long as they are read.
  void ReadGaugesFrom(std::function<ServerGauges()> gauges);

  // Returns the metrics of a game in a mode, which live as long as this object.
  GameMetrics& OfGame(absl::string_view game, absl::string_view mode);

  // Counts an executed request of a stream: the wait for its turn, and its execution time.
  void AddRequest(absl::Duration queued, absl::Duration ran);
  // Counts bytes of stream messages.
  void AddReceivedBytes(int64_t bytes);
  void AddSentBytes(int64_t bytes);
  // Counts a call or stream of `method` ("PoolService/GetPool") that ended with an error.
  void AddError(absl::string_view method, absl::StatusCode code);

  StreamTotals stream_totals() const;
  // Returns all metrics in Prometheus' text format 0.0.4.
  std::string Text() const;
  // The same for MetricsPage.
  std::shared_ptr<prometheus::Collectable> collectable() const;

 private:
  class Families;

  const std::shared_ptr<Families> families_;
};

}  // namespace procgen

#endif  // SERVER_METRICS_METRICS_H_
