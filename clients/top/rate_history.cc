#include "clients/top/rate_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "absl/time/time.h"

namespace procgen_top {
namespace {

constexpr size_t kLevels = 8;
constexpr std::array<const char*, kLevels> kBars = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
constexpr std::array<const char*, kLevels> kAsciiBars = {"_", ".", ":", "-", "=", "+", "*", "#"};

}  // namespace

double RateBetween(int64_t before, int64_t now, double seconds) {
  return seconds > 0 ? static_cast<double>(std::max<int64_t>(0, now - before)) / seconds : 0;
}

void RateHistory::Add(const Sample& before, const Sample& now) {
  std::map<std::string, int64_t> steps_before;
  for (const procgen::v1::Pool& pool : before.pools) {
    steps_before[pool.name()] = pool.step_count();
  }
  std::map<std::string, std::deque<double>> rates;
  for (const procgen::v1::Pool& pool : now.pools) {
    std::deque<double>& own = rates[pool.name()];
    own = std::move(rates_[pool.name()]);
    own.push_back(RateBetween(steps_before[pool.name()], pool.step_count(),
                              absl::ToDoubleSeconds(now.time - before.time)));
    if (own.size() > kLength) {
      own.pop_front();
    }
  }
  rates_ = std::move(rates);
}

double RateHistory::RateOf(const std::string& pool) const {
  const auto found = rates_.find(pool);
  return found == rates_.end() ? 0 : found->second.back();
}

std::string RateHistory::SparklineOf(const std::string& pool, bool is_utf8) const {
  const auto found = rates_.find(pool);
  if (found == rates_.end()) {
    std::string blank(kLength, ' ');
    return blank;
  }
  const double most = *std::max_element(found->second.begin(), found->second.end());
  std::string line(kLength - found->second.size(), ' ');
  for (const double rate : found->second) {
    const double share = most > 0 ? rate / most : 0;
    const auto level = static_cast<size_t>(std::lround(share * (kLevels - 1)));
    line += is_utf8 ? kBars[level] : kAsciiBars[level];
  }
  return line;
}

}  // namespace procgen_top
