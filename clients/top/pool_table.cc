#include "clients/top/pool_table.h"

#include <algorithm>
#include <cstdint>
#include <tuple>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "absl/time/time.h"
#include "clients/top/text_table.h"

namespace procgen_top {
namespace {

namespace v1 = procgen::v1;

constexpr int kGamesShown = 3;

std::string GamesText(const v1::PoolSpec& spec) {
  const int shown = std::min(kGamesShown, spec.games_size());
  std::string text = absl::StrJoin(spec.games().begin(), spec.games().begin() + shown, ",");
  if (shown < spec.games_size()) {
    absl::StrAppend(&text, ",+", spec.games_size() - shown);
  }
  return text;
}

std::string ModeText(const v1::PoolSpec& spec) {
  if (spec.options().distribution_mode() == v1::DISTRIBUTION_MODE_UNSPECIFIED) {
    return "";
  }
  const std::string name = v1::DistributionMode_Name(spec.options().distribution_mode());
  return absl::AsciiStrToLower(absl::StripPrefix(name, "DISTRIBUTION_MODE_"));
}

absl::Duration AgeOf(const v1::Pool& pool, absl::Time now) {
  return now - absl::FromUnixSeconds(pool.create_time().seconds());
}

// "58s", "12m", "3h" or "2d".
std::string DurationText(absl::Duration duration) {
  const int64_t seconds = std::max<int64_t>(0, absl::ToInt64Seconds(duration));
  constexpr int64_t kMinute = 60;
  constexpr int64_t kHour = 60 * kMinute;
  constexpr int64_t kDay = 24 * kHour;
  return seconds < 2 * kMinute ? absl::StrCat(seconds, "s")
         : seconds < 2 * kHour ? absl::StrCat(seconds / kMinute, "m")
         : seconds < 2 * kDay  ? absl::StrCat(seconds / kHour, "h")
                               : absl::StrCat(seconds / kDay, "d");
}

double LatencyMs(const v1::Pool& pool) {
  const auto& p50 = pool.request_duration_p50();
  return static_cast<double>(p50.seconds()) * 1e3 + static_cast<double>(p50.nanos()) / 1e6;
}

std::vector<std::string> RowOf(const v1::Pool& pool, const Sample& now, const RateHistory& history,
                               bool is_utf8) {
  const bool has_episodes = pool.episode_count() > 0;
  return {
      Shown(pool.name()),
      Shown(pool.owner()),
      Shown(GamesText(pool.spec())),
      Shown(ModeText(pool.spec())),
      absl::StrCat(pool.spec().env_count()),
      pool.attached() ? "yes" : "no",
      absl::StrFormat("%.0f", history.RateOf(pool.name())),
      history.SparklineOf(pool.name(), is_utf8),
      pool.has_request_duration_p50() ? absl::StrFormat("%.3g ms", LatencyMs(pool)) : "-",
      absl::StrCat(pool.step_count()),
      absl::StrCat(pool.episode_count()),
      has_episodes ? absl::StrFormat("%.2f", pool.mean_episode_return()) : "-",
      has_episodes ? absl::StrFormat("%.0f", pool.mean_episode_length()) : "-",
      pool.has_create_time() ? DurationText(AgeOf(pool, now.time)) : "-",
      pool.has_expire_time()
          ? DurationText(absl::FromUnixSeconds(pool.expire_time().seconds()) - now.time)
          : "-",
  };
}

// The value by which a pool is sorted, the largest first; 0 for names.
double ValueOf(const v1::Pool& pool, const Sample& now, const RateHistory& history, SortKey key) {
  switch (key) {
    case SortKey::kSteps:
      return history.RateOf(pool.name());
    case SortKey::kReturn:
      return pool.mean_episode_return();
    case SortKey::kLength:
      return pool.mean_episode_length();
    case SortKey::kLatency:
      return LatencyMs(pool);
    case SortKey::kAge:
      return absl::ToDoubleSeconds(AgeOf(pool, now.time));
    case SortKey::kName:
      return 0;
  }
  return 0;
}

}  // namespace

const std::vector<SortChoice>& SortChoices() {
  static const auto& choices = *new std::vector<SortChoice>({{SortKey::kSteps, "steps", 's'},
                                                             {SortKey::kReturn, "return", 'r'},
                                                             {SortKey::kLength, "length", 'l'},
                                                             {SortKey::kLatency, "latency", 't'},
                                                             {SortKey::kAge, "age", 'a'},
                                                             {SortKey::kName, "name", 'n'}});
  return choices;
}

std::optional<SortKey> SortKeyOf(absl::string_view name) {
  for (const SortChoice& choice : SortChoices()) {
    if (name == choice.name) {
      return choice.sort_key;
    }
  }
  return std::nullopt;
}

std::vector<std::string> PoolTableOf(const Sample& now, const RateHistory& history,
                                     const PoolTableOptions& options) {
  std::vector<const v1::Pool*> pools;
  for (const v1::Pool& pool : now.pools) {
    pools.push_back(&pool);
  }
  std::sort(pools.begin(), pools.end(), [&](const v1::Pool* left, const v1::Pool* right) {
    const auto rank = [&](const v1::Pool& pool) {
      return std::make_tuple(-ValueOf(pool, now, history, options.sort_key), pool.name());
    };
    return rank(*left) < rank(*right);
  });
  if (options.is_reversed) {
    std::reverse(pools.begin(), pools.end());
  }
  std::vector<std::vector<std::string>> rows;
  rows.reserve(pools.size());
  for (const v1::Pool* pool : pools) {
    rows.push_back(RowOf(*pool, now, history, options.is_utf8));
  }
  return AlignedLines({{"POOL"},
                       {"OWNER"},
                       {"GAMES"},
                       {"MODE"},
                       {"ENVS", true},
                       {"STREAM"},
                       {"STEPS/S", true},
                       {"HISTORY"},
                       {"P50", true},
                       {"STEPS", true},
                       {"EPISODES", true},
                       {"RETURN", true},
                       {"LENGTH", true},
                       {"AGE", true},
                       {"LEASE", true}},
                      rows);
}

}  // namespace procgen_top
