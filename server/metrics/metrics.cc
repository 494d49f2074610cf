#include "server/metrics/metrics.h"

#include <map>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "prometheus/collectable.h"
#include "prometheus/counter.h"
#include "prometheus/gauge.h"
#include "prometheus/registry.h"
#include "prometheus/text_serializer.h"

namespace procgen {
namespace {

using prometheus::ClientMetric;
using prometheus::Counter;
using prometheus::Family;
using prometheus::Gauge;
using prometheus::Labels;
using prometheus::MetricFamily;
using prometheus::Registry;

// Bounds of request times in seconds: from a step of one environment without pictures (a few us) to
// unacceptable waits.
constexpr double kSecondsBounds[] = {1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2,
                                     2e-2, 5e-2, 0.1,  0.2,  0.5,  1,    2,    5,    10};
// Returns range from -60 (fruitbot) to over 60 (starpilot); in many games they are 0 or 10.
constexpr double kReturnBounds[] = {-20, -10, -5, -1, 0, 1, 2, 5, 8, 10, 15, 20, 40, 80};
constexpr double kLengthBounds[] = {1, 10, 50, 100, 200, 500, 1000, 2000, 4000, 8000};

std::string Owned(absl::string_view text) { return std::string(text); }

class CountedGame final : public GameMetrics {
 public:
  explicit CountedGame(Counter& steps) : steps_(steps) {}

  void AddSteps(int64_t count) override { steps_.Increment(static_cast<double>(count)); }
  void AddEpisode(float episode_return, int32_t steps) override {
    returns_.Add(static_cast<double>(episode_return));
    lengths_.Add(steps);
  }

  const AtomicHistogram& returns() const { return returns_; }
  const AtomicHistogram& lengths() const { return lengths_; }

 private:
  Counter& steps_;
  AtomicHistogram returns_{kReturnBounds};
  AtomicHistogram lengths_{kLengthBounds};
};

ClientMetric MetricOf(const AtomicHistogram& histogram, std::vector<ClientMetric::Label> labels) {
  const HistogramCounts counted = histogram.Counts();
  ClientMetric metric;
  metric.label = std::move(labels);
  metric.histogram.sample_sum = counted.sum;
  for (size_t i = 0; i < counted.counts.size(); ++i) {
    metric.histogram.sample_count += static_cast<uint64_t>(counted.counts[i]);
    if (i < counted.bounds.size()) {
      metric.histogram.bucket.push_back({metric.histogram.sample_count, counted.bounds[i]});
    }
  }
  return metric;
}

MetricFamily HistogramFamily(const char* name, const char* help,
                             std::vector<ClientMetric> metrics) {
  return {name, help, prometheus::MetricType::Histogram, std::move(metrics)};
}

}  // namespace

// All metrics. Collect reads the gauges.
class Metrics::Families final : public prometheus::Collectable {
 public:
  explicit Families(absl::string_view version)
      : received(AddCounter("procgen_stream_received_bytes_total",
                            "Bytes of the messages that streams received.")),
        sent(AddCounter("procgen_stream_sent_bytes_total",
                        "Bytes of the messages that streams sent.")),
        errors(CounterFamily("procgen_errors_total",
                             "Calls and streams that ended with an error, by method and code.")),
        steps_(CounterFamily("procgen_steps_total",
                             "Environment steps; one that repeats its action counts once.")),
        pools_(AddGauge("procgen_pools", "Current pools.")),
        environments_(AddGauge("procgen_environments", "Environments of all pools.")),
        workers_(AddGauge("procgen_workers", "Threads that step environments.")),
        draining_(AddGauge("procgen_draining", "1 while the server drains, otherwise 0.")) {
    prometheus::BuildGauge()
        .Name("procgen_build_info")
        .Help("1; the server's version is a label.")
        .Register(registry_)
        .Add({{"version", Owned(version)}})
        .Set(1);
  }

  void ReadGaugesFrom(std::function<ServerGauges()> gauges) {
    absl::MutexLock lock(&mutex_);
    read_gauges_ = std::move(gauges);
  }

  GameMetrics& OfGame(absl::string_view game, absl::string_view mode) {
    absl::MutexLock lock(&mutex_);
    std::unique_ptr<CountedGame>& counted = games_[{Owned(game), Owned(mode)}];
    if (counted == nullptr) {
      const Labels labels = {{"game", Owned(game)}, {"mode", Owned(mode)}};
      counted = std::make_unique<CountedGame>(steps_.Add(labels));
    }
    return *counted;
  }

  std::vector<MetricFamily> Collect() const override {
    SetGauges();
    std::vector<MetricFamily> families = registry_.Collect();
    AddGames(&families);
    families.push_back(HistogramFamily("procgen_request_queue_seconds",
                                       "From a stream request's arrival to its turn at the pool.",
                                       {MetricOf(queued, {})}));
    families.push_back(HistogramFamily("procgen_request_run_seconds",
                                       "From a stream request's turn to its response being ready.",
                                       {MetricOf(ran, {})}));
    return families;
  }

 private:
  Family<Counter>& CounterFamily(const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry_);
  }
  Counter& AddCounter(const char* name, const char* help) {
    return CounterFamily(name, help).Add({});
  }
  Gauge& AddGauge(const char* name, const char* help) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(registry_).Add({});
  }

  void SetGauges() const {
    std::function<ServerGauges()> read_gauges;
    {
      absl::MutexLock lock(&mutex_);
      read_gauges = read_gauges_;
    }
    if (read_gauges == nullptr) {
      return;
    }
    const ServerGauges now = read_gauges();
    pools_.Set(now.pool_count);
    environments_.Set(now.env_count);
    workers_.Set(now.worker_count);
    draining_.Set(now.draining ? 1 : 0);
  }

  void AddGames(std::vector<MetricFamily>* families) const {
    std::vector<ClientMetric> returns;
    std::vector<ClientMetric> lengths;
    {
      absl::MutexLock lock(&mutex_);
      for (const auto& [key, game] : games_) {
        const std::vector<ClientMetric::Label> labels = {{"game", key.first}, {"mode", key.second}};
        returns.push_back(MetricOf(game->returns(), labels));
        lengths.push_back(MetricOf(game->lengths(), labels));
      }
    }
    families->push_back(HistogramFamily("procgen_episode_return",
                                        "Sum of the rewards of episodes that ended.",
                                        std::move(returns)));
    families->push_back(HistogramFamily("procgen_episode_length_steps",
                                        "Steps of episodes that ended.", std::move(lengths)));
  }

  Registry registry_;

 public:
  Counter& received;
  Counter& sent;
  Family<Counter>& errors;
  AtomicHistogram queued{kSecondsBounds};
  AtomicHistogram ran{kSecondsBounds};

 private:
  Family<Counter>& steps_;
  Gauge& pools_;
  Gauge& environments_;
  Gauge& workers_;
  Gauge& draining_;

  mutable absl::Mutex mutex_;
  std::function<ServerGauges()> read_gauges_ ABSL_GUARDED_BY(mutex_);
  std::map<std::pair<std::string, std::string>, std::unique_ptr<CountedGame>> games_
      ABSL_GUARDED_BY(mutex_);  // by game and mode
};

Metrics::Metrics(absl::string_view version) : families_(std::make_shared<Families>(version)) {}

Metrics::~Metrics() = default;

void Metrics::ReadGaugesFrom(std::function<ServerGauges()> gauges) {
  families_->ReadGaugesFrom(std::move(gauges));
}

GameMetrics& Metrics::OfGame(absl::string_view game, absl::string_view mode) {
  return families_->OfGame(game, mode);
}

void Metrics::AddRequest(absl::Duration queued, absl::Duration ran) {
  families_->queued.Add(absl::ToDoubleSeconds(queued));
  families_->ran.Add(absl::ToDoubleSeconds(ran));
}

void Metrics::AddReceivedBytes(int64_t bytes) {
  families_->received.Increment(static_cast<double>(bytes));
}

void Metrics::AddSentBytes(int64_t bytes) { families_->sent.Increment(static_cast<double>(bytes)); }

void Metrics::AddError(absl::string_view method, absl::StatusCode code) {
  families_->errors.Add({{"method", Owned(method)}, {"code", absl::StatusCodeToString(code)}})
      .Increment();
}

StreamTotals Metrics::stream_totals() const {
  return {static_cast<int64_t>(families_->received.Value()),
          static_cast<int64_t>(families_->sent.Value()), families_->queued.Counts(),
          families_->ran.Counts()};
}

std::string Metrics::Text() const {
  return prometheus::TextSerializer().Serialize(families_->Collect());
}

std::shared_ptr<prometheus::Collectable> Metrics::collectable() const { return families_; }

}  // namespace procgen
