#include "server/metrics/metrics.h"

#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "prometheus/collectable.h"
#include "prometheus/counter.h"
#include "prometheus/gauge.h"
#include "prometheus/histogram.h"
#include "prometheus/registry.h"
#include "prometheus/text_serializer.h"

namespace procgen {
namespace {

using prometheus::Counter;
using prometheus::Family;
using prometheus::Gauge;
using prometheus::Histogram;
using prometheus::Labels;
using prometheus::MetricFamily;
using prometheus::Registry;
using Bounds = Histogram::BucketBoundaries;

// Bounds of request times in seconds: from a step of one environment without pictures (a few us) to
// unacceptable waits.
const Bounds kSecondsBounds = {1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2,
                               2e-2, 5e-2, 0.1,  0.2,  0.5,  1,    2,    5,    10};
// Returns range from -60 (fruitbot) to over 60 (starpilot); in many games they are 0 or 10.
const Bounds kReturnBounds = {-20, -10, -5, -1, 0, 1, 2, 5, 8, 10, 15, 20, 40, 80};
const Bounds kLengthBounds = {1, 10, 50, 100, 200, 500, 1000, 2000, 4000, 8000};

std::string Owned(absl::string_view text) { return std::string(text); }

HistogramCounts CountsOf(const Histogram& histogram) {
  const auto collected = histogram.Collect().histogram;
  HistogramCounts counted;
  counted.sum = collected.sample_sum;
  uint64_t below = 0;
  for (const auto& bucket : collected.bucket) {
    counted.bounds.push_back(bucket.upper_bound);
    counted.counts.push_back(static_cast<int64_t>(bucket.cumulative_count - below));
    below = bucket.cumulative_count;
  }
  counted.bounds.pop_back();  // infinity
  return counted;
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
        steps(CounterFamily("procgen_steps_total",
                            "Environment steps; one that repeats its action counts once.")),
        returns(HistogramFamily("procgen_episode_return",
                                "Sum of the rewards of episodes that ended.")),
        lengths(HistogramFamily("procgen_episode_length_steps", "Steps of episodes that ended.")),
        queued(HistogramFamily("procgen_request_queue_seconds",
                               "From a stream request's arrival to its turn at the pool.")
                   .Add({}, kSecondsBounds)),
        ran(HistogramFamily("procgen_request_run_seconds",
                            "From a stream request's turn to its response being ready.")
                .Add({}, kSecondsBounds)),
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

  void ReadGaugesFrom(std::function<Load()> load) {
    absl::MutexLock lock(&mutex_);
    load_ = std::move(load);
  }

  std::vector<MetricFamily> Collect() const override {
    SetGauges();
    return registry_.Collect();
  }

 private:
  Family<Counter>& CounterFamily(const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry_);
  }
  Family<Histogram>& HistogramFamily(const char* name, const char* help) {
    return prometheus::BuildHistogram().Name(name).Help(help).Register(registry_);
  }
  Counter& AddCounter(const char* name, const char* help) {
    return CounterFamily(name, help).Add({});
  }
  Gauge& AddGauge(const char* name, const char* help) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(registry_).Add({});
  }

  void SetGauges() const {
    std::function<Load()> load;
    {
      absl::MutexLock lock(&mutex_);
      load = load_;
    }
    if (load == nullptr) {
      return;
    }
    const Load now = load();
    pools_.Set(now.pool_count);
    environments_.Set(now.env_count);
    workers_.Set(now.worker_count);
    draining_.Set(now.draining ? 1 : 0);
  }

  Registry registry_;

 public:
  Counter& received;
  Counter& sent;
  Family<Counter>& errors;
  Family<Counter>& steps;
  Family<Histogram>& returns;
  Family<Histogram>& lengths;
  Histogram& queued;
  Histogram& ran;

 private:
  Gauge& pools_;
  Gauge& environments_;
  Gauge& workers_;
  Gauge& draining_;

  mutable absl::Mutex mutex_;
  std::function<Load()> load_ ABSL_GUARDED_BY(mutex_);
};

void GameMetrics::AddSteps(int64_t count) { steps_->Increment(static_cast<double>(count)); }

void GameMetrics::AddEpisode(float episode_return, int32_t steps) {
  returns_->Observe(static_cast<double>(episode_return));
  lengths_->Observe(steps);
}

Metrics::Metrics(absl::string_view version) : families_(std::make_shared<Families>(version)) {}

Metrics::~Metrics() = default;

void Metrics::ReadGaugesFrom(std::function<Load()> load) {
  families_->ReadGaugesFrom(std::move(load));
}

GameMetrics Metrics::OfGame(absl::string_view game, absl::string_view mode) {
  const Labels labels = {{"game", Owned(game)}, {"mode", Owned(mode)}};
  return {&families_->steps.Add(labels), &families_->returns.Add(labels, kReturnBounds),
          &families_->lengths.Add(labels, kLengthBounds)};
}

void Metrics::AddRequest(absl::Duration queued, absl::Duration ran) {
  families_->queued.Observe(absl::ToDoubleSeconds(queued));
  families_->ran.Observe(absl::ToDoubleSeconds(ran));
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
          static_cast<int64_t>(families_->sent.Value()), CountsOf(families_->queued),
          CountsOf(families_->ran)};
}

std::string Metrics::Text() const {
  return prometheus::TextSerializer().Serialize(families_->Collect());
}

std::shared_ptr<prometheus::Collectable> Metrics::collectable() const { return families_; }

}  // namespace procgen
