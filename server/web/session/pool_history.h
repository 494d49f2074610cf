#ifndef SERVER_WEB_SESSION_POOL_HISTORY_H_
#define SERVER_WEB_SESSION_POOL_HISTORY_H_

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "procgen/v1/pools.pb.h"
#include "server/web/json/message.h"

namespace procgen::web {

// Time series of pools, one row a second. Threads: compatible (one at a time).
class PoolHistory {
 public:
  // Rows per pool: ten minutes.
  static constexpr size_t kRowsMax = 600;

  // Adds a row for each pool. Drops the history of pools that are not in `pools`.
  void Add(double time_s, const std::vector<procgen::v1::Pool>& pools);

  // Steps per second between the last two rows; 0 with fewer than two.
  double StepsPerSecond(const procgen::v1::Pool& pool) const;
  // The members `columns` and `rows` of pool.history.
  Json RowsOf(const procgen::v1::Pool& pool) const;

 private:
  // Names are unique per owner only, and may be reused, so the creation time is stored.
  struct Course {
    double create_time_s = 0;
    int64_t step_count = 0;  // at the last row
    double time_s = 0;
    double steps_per_second = 0;
    std::deque<std::vector<float>> rows;
    std::deque<double> times_s;
  };
  using Key = std::pair<std::string, std::string>;  // owner, name

  static Key KeyOf(const procgen::v1::Pool& pool) { return {pool.owner(), pool.name()}; }
  const Course* Find(const procgen::v1::Pool& pool) const;
  static void AddRow(double time_s, const procgen::v1::Pool& pool, Course* course);

  std::map<Key, Course> courses_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_POOL_HISTORY_H_
