#include "clients/top/screen.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "clients/top/node_table.h"

namespace procgen_top {
namespace {

namespace v1 = procgen::v1;

constexpr int kGamesShown = 3;

// Rate per second between two counts; 0 if the count has dropped, as after a restart of the server.
double RateOf(int64_t before, int64_t now, double seconds) {
  return seconds > 0 ? static_cast<double>(std::max<int64_t>(0, now - before)) / seconds : 0;
}

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

std::string GamesText(const v1::PoolSpec& spec) {
  const int shown = std::min(kGamesShown, spec.games_size());
  std::string text = absl::StrJoin(spec.games().begin(), spec.games().begin() + shown, ",");
  if (shown < spec.games_size()) {
    absl::StrAppend(&text, ",+", spec.games_size() - shown);
  }
  return text;
}

std::string LeaseText(const v1::Pool& pool, absl::Time now) {
  if (!pool.has_expire_time()) {
    return "-";
  }
  const absl::Duration left = absl::FromUnixSeconds(pool.expire_time().seconds()) - now;
  return absl::StrCat(std::max<int64_t>(0, absl::ToInt64Seconds(left)), " s");
}

// The mean return of the recent episodes.
std::string ReturnText(const v1::Pool& pool) {
  return pool.episode_count() == 0 ? "-" : absl::StrFormat("%.2f", pool.mean_episode_return());
}

struct Row {
  const v1::Pool* pool = nullptr;
  double steps_per_second = 0;
};

// Pools by descending step rate, then oldest first.
std::vector<Row> RowsOf(const Sample& before, const Sample& now, double seconds) {
  std::map<std::string, int64_t> steps_before;
  for (const v1::Pool& pool : before.pools) {
    steps_before[pool.name()] = pool.step_count();
  }
  std::vector<Row> rows;
  for (const v1::Pool& pool : now.pools) {
    rows.push_back({&pool, RateOf(steps_before[pool.name()], pool.step_count(), seconds)});
  }
  std::stable_sort(rows.begin(), rows.end(), [](const Row& left, const Row& right) {
    return left.steps_per_second > right.steps_per_second;
  });
  return rows;
}

constexpr char kRowFormat[] = "%-*s  %-*s  %-*s  %6s  %-6s  %10s  %12s  %9s  %9s  %s";

// Escapes text of the server, which must not control the terminal.
std::string Shown(const std::string& text) { return text.empty() ? "-" : absl::CHexEscape(text); }

void AddPools(const Sample& before, const Sample& now, double seconds,
              std::vector<std::string>* lines) {
  const std::vector<Row> rows = RowsOf(before, now, seconds);
  size_t name_width = 4;
  size_t owner_width = 5;
  size_t games_width = 5;
  for (const Row& row : rows) {
    name_width = std::max(name_width, Shown(row.pool->name()).size());
    owner_width = std::max(owner_width, Shown(row.pool->owner()).size());
    games_width = std::max(games_width, Shown(GamesText(row.pool->spec())).size());
  }
  const auto add = [&](const std::string& name, const std::string& owner, const std::string& games,
                       const std::string& environments, const std::string& stream,
                       const std::string& rate, const std::string& steps,
                       const std::string& episodes, const std::string& mean_return,
                       const std::string& lease) {
    lines->push_back(absl::StrFormat(kRowFormat, static_cast<int>(name_width), name,
                                     static_cast<int>(owner_width), owner,
                                     static_cast<int>(games_width), games, environments, stream,
                                     rate, steps, episodes, mean_return, lease));
  };
  add("POOL", "OWNER", "GAMES", "ENVS", "STREAM", "STEPS/S", "STEPS", "EPISODES", "RETURN",
      "LEASE");
  for (const Row& row : rows) {
    const v1::Pool& pool = *row.pool;
    add(Shown(pool.name()), Shown(pool.owner()), Shown(GamesText(pool.spec())),
        absl::StrCat(pool.spec().env_count()), pool.attached() ? "yes" : "no",
        absl::StrFormat("%.0f", row.steps_per_second), absl::StrCat(pool.step_count()),
        absl::StrCat(pool.episode_count()), ReturnText(pool), LeaseText(pool, now.time));
  }
}

}  // namespace

std::vector<std::string> ScreenOf(const std::string& title, const Sample& before,
                                  const Sample& now) {
  const double seconds = absl::ToDoubleSeconds(now.time - before.time);
  const v1::Load& load = now.load;
  const v1::LatencyHistogram queue_wait = Between(before.load.queue_wait(), load.queue_wait());
  const v1::LatencyHistogram execution_time =
      Between(before.load.execution_time(), load.execution_time());
  const double received =
      RateOf(before.load.stream_received_bytes(), load.stream_received_bytes(), seconds);
  const double sent = RateOf(before.load.stream_sent_bytes(), load.stream_sent_bytes(), seconds);
  std::vector<std::string> lines;
  lines.push_back(absl::StrCat(Shown(title), load.draining() ? "   DRAINING" : ""));
  lines.push_back(absl::StrFormat(
      "%-9s pools %d   environments %d   streams %d   workers %d   resume buffers %s", "holds",
      load.pool_count(), load.env_count(), load.stream_count(), load.worker_count(),
      BytesText(static_cast<double>(load.resume_buffer_bytes()))));
  lines.push_back(absl::StrFormat(
      "%-9s steps/s %.0f   requests/s %.1f   in %s/s   out %s/s", "does",
      RateOf(before.load.step_count(), load.step_count(), seconds),
      RateOf(0, CountOf(execution_time), seconds), BytesText(received), BytesText(sent)));
  lines.push_back(LatencyText("queue", queue_wait));
  lines.push_back(LatencyText("run", execution_time));
  lines.emplace_back("");
  if (std::vector<std::string> nodes = NodeTableOf(now.nodes); !nodes.empty()) {
    lines.insert(lines.end(), nodes.begin(), nodes.end());
    lines.emplace_back("");
  }
  AddPools(before, now, seconds, &lines);
  return lines;
}

}  // namespace procgen_top
