#ifndef CLIENTS_TOP_RATE_HISTORY_H_
#define CLIENTS_TOP_RATE_HISTORY_H_

#include <cstddef>
#include <deque>
#include <map>
#include <string>

#include "clients/top/sample.h"

namespace procgen_top {

// The step rates of each pool in the last intervals.
class RateHistory {
 public:
  // Number of intervals that are kept.
  static constexpr size_t kLength = 16;

  // Adds the interval between two samples. Drops pools that `now` does not have.
  void Add(const Sample& before, const Sample& now);

  // Steps per second in the last interval; 0 for an unknown pool.
  double RateOf(const std::string& pool) const;
  // The rates of a pool as kLength characters, the last interval at the right: bars relative to the
  // largest rate, in ASCII unless `is_utf8`.
  std::string SparklineOf(const std::string& pool, bool is_utf8) const;

 private:
  std::map<std::string, std::deque<double>> rates_;  // by name of the pool
};

// Rate per second between two counts; 0 if the count has dropped, as after a restart of the server.
double RateBetween(int64_t before, int64_t now, double seconds);

}  // namespace procgen_top

#endif  // CLIENTS_TOP_RATE_HISTORY_H_
