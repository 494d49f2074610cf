#include "server/metrics/metrics.h"

#include <map>
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
using prometheus::Registry;

using Bounds = Histogram::BucketBoundaries;

// From a microsecond, a step of one environment without pictures, to what nobody should wait.
const Bounds& SecondsBounds() {
  static const Bounds* const kBounds =
      new Bounds{1e-6, 1e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 0.1, 1, 10};
  return *kBounds;
}

// Returns reach from -60 (fruitbot) to over 60 (starpilot); many games give 0 or 10.
const Bounds& ReturnBounds() {
  static const Bounds* const kBounds =
      new Bounds{-20, -10, -5, -1, 0, 1, 2, 5, 8, 10, 15, 20, 40, 80};
  return *kBounds;
}

const Bounds& LengthBounds() {
  static const Bounds* const kBounds = new Bounds{1, 10, 50, 100, 200, 500, 1000, 2000, 4000, 8000};
  return *kBounds;
}

std::string Owned(absl::string_view text) { return std::string(text); }

class CountedGame final : public GameMetrics {
 public:
  CountedGame(Counter& steps, Histogram& returns, Histogram& lengths)
      : steps_(steps), returns_(returns), lengths_(lengths) {}

  void AddSteps(int64_t count) override { steps_.Increment(static_cast<double>(count)); }
  void AddEpisode(float episode_return, int32_t steps) override {
    returns_.Observe(static_cast<double>(episode_return));
    lengths_.Observe(steps);
  }

 private:
  Counter& steps_;
  Histogram& returns_;
  Histogram& lengths_;
};

}  // namespace

// All that is counted. What is read last is asked for when Prometheus asks.
class Metrics::Families final : public prometheus::Collectable {
 public:
  explicit Families(absl::string_view version)
      : steps(CounterFamily("procgen_steps_total", "Environment steps.")),
        returns(HistogramFamily("procgen_episode_return",
                                "Sum of the rewards of episodes that ended.")),
        lengths(HistogramFamily("procgen_episode_length_steps", "Steps of episodes that ended.")),
        queued(HistogramFamily("procgen_request_queue_seconds",
                               "From a stream request's arrival to its turn at the pool.")
                   .Add({}, SecondsBounds())),
        ran(HistogramFamily("procgen_request_run_seconds",
                            "From a stream request's turn to the end of stepping.")
                .Add({}, SecondsBounds())),
        received(CounterFamily("procgen_stream_received_bytes_total",
                               "Bytes of the messages that streams received.")
                     .Add({})),
        sent(CounterFamily("procgen_stream_sent_bytes_total",
                           "Bytes of the messages that streams sent.")
                 .Add({})),
        streams(CounterFamily("procgen_streams_attached_total",
                              "Streams that attached to a pool; resumed: after one broke off.")),
        errors(CounterFamily("procgen_errors_total",
                             "Calls and streams that ended with an error, by method and code.")),
        pool_gauge_(GaugeFamily("procgen_pools", "Pools at this time.").Add({})),
        environment_gauge_(
            GaugeFamily("procgen_environments", "Environments of all pools.").Add({})),
        stream_gauge_(GaugeFamily("procgen_streams", "Streams that are attached.").Add({})),
        worker_gauge_(GaugeFamily("procgen_workers", "Threads that step environments.").Add({})),
        draining_gauge_(
            GaugeFamily("procgen_draining", "1 while the server drains, otherwise 0.").Add({})) {
    GaugeFamily("procgen_build_info", "1; the server's version is a label.")
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
      counted =
          std::make_unique<CountedGame>(steps.Add(labels), returns.Add(labels, ReturnBounds()),
                                        lengths.Add(labels, LengthBounds()));
    }
    return *counted;
  }

  std::vector<prometheus::MetricFamily> Collect() const override {
    absl::MutexLock lock(&mutex_);
    if (read_gauges_ != nullptr) {
      const ServerGauges now = read_gauges_();
      pool_gauge_.Set(now.pool_count);
      environment_gauge_.Set(now.environment_count);
      stream_gauge_.Set(now.stream_count);
      worker_gauge_.Set(now.worker_count);
      draining_gauge_.Set(now.draining ? 1 : 0);
    }
    return registry_.Collect();
  }

 private:
  Family<Counter>& CounterFamily(const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry_);
  }
  Family<Gauge>& GaugeFamily(const char* name, const char* help) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(registry_);
  }
  Family<Histogram>& HistogramFamily(const char* name, const char* help) {
    return prometheus::BuildHistogram().Name(name).Help(help).Register(registry_);
  }

  Registry registry_;

 public:
  Family<Counter>& steps;
  Family<Histogram>& returns;
  Family<Histogram>& lengths;
  Histogram& queued;
  Histogram& ran;
  Counter& received;
  Counter& sent;
  Family<Counter>& streams;
  Family<Counter>& errors;

 private:
  Gauge& pool_gauge_;
  Gauge& environment_gauge_;
  Gauge& stream_gauge_;
  Gauge& worker_gauge_;
  Gauge& draining_gauge_;

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
  families_->queued.Observe(absl::ToDoubleSeconds(queued));
  families_->ran.Observe(absl::ToDoubleSeconds(ran));
}

void Metrics::AddReceivedBytes(int64_t bytes) {
  families_->received.Increment(static_cast<double>(bytes));
}

void Metrics::AddSentBytes(int64_t bytes) { families_->sent.Increment(static_cast<double>(bytes)); }

void Metrics::AddStream(bool resumed) {
  families_->streams.Add({{"resumed", resumed ? "true" : "false"}}).Increment();
}

void Metrics::AddError(absl::string_view method, absl::StatusCode code) {
  families_->errors
      .Add({{"method", Owned(method)}, {"code", absl::StatusCodeToString(code)}})
      .Increment();
}

std::string Metrics::Text() const {
  return prometheus::TextSerializer().Serialize(families_->Collect());
}

std::shared_ptr<prometheus::Collectable> Metrics::collectable() const { return families_; }

}  // namespace procgen
