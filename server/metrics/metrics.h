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

// How a server stands when its metrics are read.
struct ServerGauges {
  int32_t pool_count = 0;
  int32_t env_count = 0;
  int32_t stream_count = 0;
  int32_t worker_count = 0;
  int64_t resume_buffer_bytes = 0;
  bool draining = false;
};

// What was counted of all streams since the start, for who does not read Prometheus' text.
struct StreamTotals {
  int64_t received_bytes = 0;
  int64_t sent_bytes = 0;
  HistogramCounts queue_seconds;
  HistogramCounts run_seconds;
};

// What is counted of one game in one mode, over all pools. Threads: any method from any thread;
// none allocates or waits.
class GameMetrics {
 public:
  virtual ~GameMetrics() = default;

  virtual void AddSteps(int64_t count) = 0;
  virtual void AddEpisode(float episode_return, int32_t steps) = 0;
};

// Counts what a server does, in the form of Prometheus; README.md lists the names.
// Threads: any method from any thread. What is called with each request of a stream (AddRequest and
// the bytes) neither allocates nor waits.
class Metrics {
 public:
  explicit Metrics(absl::string_view version);
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  // Asks `gauges` whenever the metrics are read, from then on. It must not block for long, and
  // must be callable until nobody reads any more.
  void ReadGaugesFrom(std::function<ServerGauges()> gauges);

  // The metrics of a game in a mode; they live as long as this.
  GameMetrics& OfGame(absl::string_view game, absl::string_view mode);

  // A request of a stream was carried out: it waited for its turn, and then ran.
  void AddRequest(absl::Duration queued, absl::Duration ran);
  // Bytes of messages of streams.
  void AddReceivedBytes(int64_t bytes);
  void AddSentBytes(int64_t bytes);
  // A stream has attached; `resumed`: it goes on where another broke off.
  void AddStream(bool resumed);
  // A pool was freed because nobody held it.
  void AddExpiredPool();
  // A shard of a fleet's pool left its node.
  void AddFleetShardMigration();
  // A request waited for that, so long from its beginning to its end.
  void AddFleetFailover(absl::Duration duration);
  // So many shards more, or fewer, wait for a node.
  void AddFleetWaits(int32_t change);
  // So many pools more, or fewer, of a fleet with --state_dir cannot be written.
  void AddFleetNotDurable(int32_t change);
  // A call or stream of `method` ("PoolService/CreatePool") ended with an error.
  void AddError(absl::string_view method, absl::StatusCode code);

  StreamTotals stream_totals() const;
  // All metrics, as Prometheus reads them (text format 0.0.4).
  std::string Text() const;
  // The same for who serves them over HTTP.
  std::shared_ptr<prometheus::Collectable> collectable() const;

 private:
  class Families;

  const std::shared_ptr<Families> families_;
};

}  // namespace procgen

#endif  // SERVER_METRICS_METRICS_H_
