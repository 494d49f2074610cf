#include "clients/top/screen.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"
#include "clients/top/node_table.h"
#include "clients/top/text_table.h"

namespace procgen_top {
namespace {

namespace v1 = procgen::v1;

// "12.3 MB"; units of 1000.
std::string BytesText(double bytes) {
  const char* unit = "B";
  for (const char* larger : {"kB", "MB", "GB", "TB"}) {
    if (bytes < 1000) {
      break;
    }
    bytes /= 1000;
    unit = larger;
  }
  return absl::StrFormat("%.1f %s", bytes, unit);
}

std::string SecondsText(double seconds) {
  if (seconds < 1e-3) {
    return absl::StrFormat("%.3g us", seconds * 1e6);
  }
  return seconds < 1 ? absl::StrFormat("%.3g ms", seconds * 1e3)
                     : absl::StrFormat("%.3g s", seconds);
}

// Histogram of the time between two samples; since the server's start if they do not match.
v1::LatencyHistogram Between(const v1::LatencyHistogram& before, const v1::LatencyHistogram& now) {
  v1::LatencyHistogram between = now;
  if (before.counts_size() != now.counts_size() || before.sum_seconds() > now.sum_seconds()) {
    return between;
  }
  for (int i = 0; i < now.counts_size(); ++i) {
    between.set_counts(i, std::max<int64_t>(0, now.counts(i) - before.counts(i)));
  }
  between.set_sum_seconds(now.sum_seconds() - before.sum_seconds());
  return between;
}

int64_t CountOf(const v1::LatencyHistogram& latency) {
  int64_t count = 0;
  for (const int64_t counted : latency.counts()) {
    count += counted;
  }
  return count;
}

// The bucket bound of a quantile, as text.
std::string QuantileText(const v1::LatencyHistogram& latency, double share) {
  const auto wanted =
      static_cast<int64_t>(std::ceil(share * static_cast<double>(CountOf(latency))));
  int64_t count = 0;
  for (int i = 0; i < latency.bounds_seconds_size(); ++i) {
    count += latency.counts(i);
    if (count >= wanted) {
      return absl::StrCat("<= ", SecondsText(latency.bounds_seconds(i)));
    }
  }
  return "beyond";
}

std::string LatencyText(absl::string_view name, const v1::LatencyHistogram& latency) {
  const int64_t count = CountOf(latency);
  if (count == 0 || latency.counts_size() != latency.bounds_seconds_size() + 1) {
    return absl::StrFormat("%-9s mean -   p50 -   p99 -", name);
  }
  return absl::StrFormat("%-9s mean %s   p50 %s   p99 %s", name,
                         SecondsText(latency.sum_seconds() / static_cast<double>(count)),
                         QuantileText(latency, 0.5), QuantileText(latency, 0.99));
}

// Totals and latencies of the server.
std::vector<Line> LoadLines(const Sample& before, const Sample& now) {
  const double seconds = absl::ToDoubleSeconds(now.time - before.time);
  const v1::Load& load = now.load;
  const v1::LatencyHistogram queue_wait = Between(before.load.queue_wait(), load.queue_wait());
  const v1::LatencyHistogram execution_time =
      Between(before.load.execution_time(), load.execution_time());
  const double received =
      RateBetween(before.load.stream_received_bytes(), load.stream_received_bytes(), seconds);
  const double sent =
      RateBetween(before.load.stream_sent_bytes(), load.stream_sent_bytes(), seconds);
  return {
      {absl::StrFormat(
          "%-9s pools %d   environments %d   streams %d   workers %d   resume buffers %s", "holds",
          load.pool_count(), load.env_count(), load.stream_count(), load.worker_count(),
          BytesText(static_cast<double>(load.resume_buffer_bytes())))},
      {absl::StrFormat("%-9s steps/s %.0f   requests/s %.1f   in %s/s   out %s/s", "does",
                       RateBetween(before.load.step_count(), load.step_count(), seconds),
                       RateBetween(0, CountOf(execution_time), seconds), BytesText(received),
                       BytesText(sent))},
      {LatencyText("queue", queue_wait)},
      {LatencyText("run", execution_time)},
      {""},
  };
}

}  // namespace

Screen ScreenOf(const std::string& title, const Sample& before, const Sample& now,
                const RateHistory& history, const PoolTableOptions& options) {
  Screen screen;
  screen.head = LoadLines(before, now);
  const bool is_draining = now.load.draining();
  screen.head.insert(screen.head.begin(),
                     {absl::StrCat(Shown(title), is_draining ? "   DRAINING" : ""),
                      is_draining ? Style::kWarning : Style::kTitle});
  for (std::string& line : NodeTableOf(now.nodes)) {
    screen.head.push_back({std::move(line)});
  }
  if (!now.nodes.cluster().empty()) {
    screen.head.push_back({""});
  }
  for (std::string& line : PoolTableOf(now, history, options)) {
    screen.pools.push_back({std::move(line)});
  }
  screen.head.push_back({screen.pools.front().text, Style::kTableHead});
  screen.pools.erase(screen.pools.begin());
  return screen;
}

}  // namespace procgen_top
