#ifndef SERVER_METRICS_METRICS_H_
#define SERVER_METRICS_METRICS_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace prometheus {
class Collectable;
class Counter;
class Histogram;
}  // namespace prometheus

namespace procgen {

// The current load of a server. All but `step_count` are gauges.
struct Load {
  int32_t pool_count = 0;
  int32_t env_count = 0;
  int32_t worker_count = 0;
  int64_t step_count = 0;  // environment steps since the start
  bool draining = false;
};

// The contents of a histogram.
struct HistogramCounts {
  std::vector<double> bounds;   // ascending upper bounds of the buckets
  std::vector<int64_t> counts;  // values per bucket [bounds + 1]; the last has no upper bound
  double sum = 0;               // of all values
};

// Totals of all streams since the start, for the API's Load message.
struct StreamTotals {
  int64_t received_bytes = 0;
  int64_t sent_bytes = 0;
  HistogramCounts queue_seconds;
  HistogramCounts run_seconds;
};

// Counters of one game in one mode, over all pools. Threads: any method from any thread.
class GameMetrics {
 public:
  void AddSteps(int64_t count);
  void AddEpisode(float episode_return, int32_t steps);

 private:
  friend class Metrics;
  GameMetrics(prometheus::Counter* steps, prometheus::Histogram* returns,
              prometheus::Histogram* lengths)
      : steps_(steps), returns_(returns), lengths_(lengths) {}

  prometheus::Counter* steps_;
  prometheus::Histogram* returns_;
  prometheus::Histogram* lengths_;
};

// The metrics of a server, in Prometheus' format.
// Threads: any method from any thread.
class Metrics {
 public:
  explicit Metrics(absl::string_view version);
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  // Sets the function that returns the values of the gauges. It is called whenever the metrics are
  // read, must not block for long, and must be valid as long as they are read.
  void ReadGaugesFrom(std::function<Load()> load);

  // Returns the metrics of a game in a mode, which are valid as long as this object.
  GameMetrics OfGame(absl::string_view game, absl::string_view mode);

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
