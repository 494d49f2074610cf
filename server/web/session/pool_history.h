#ifndef SERVER_WEB_SESSION_POOL_HISTORY_H_
#define SERVER_WEB_SESSION_POOL_HISTORY_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "server/web/json/message.h"
#include "server/web/session/pool_report.h"

namespace procgen::web {

// Time series of pools: a row a second, and coarser rows for longer spans. Memory per pool is
// bounded: at most 1,320 rows of about 80 bytes. Threads: compatible (one at a time).
class PoolHistory {
 public:
  struct Resolution {
    int32_t interval_s = 0;
    size_t rows_max = 0;
  };
  // Ten minutes, an hour, a day; finest first.
  static constexpr std::array<Resolution, 3> kResolutions = {{{1, 600}, {10, 360}, {240, 360}}};
  static constexpr int32_t kSpanSMax = 86400;
  static constexpr int32_t kSpanSDefault = 600;

  // Adds a row for each pool. Drops the history of pools that are not in `reports`.
  void Add(double time_s, const std::vector<PoolReport>& reports);

  // Members of a pool in the event `pools` that only the history has: the values of the newest row
  // that are not in the API, and the time of the last step. Null if there is no history.
  Json NewestOf(const procgen::v1::Pool& pool) const;
  // The answer of pool.history: the rows of the last `span_s` seconds, in the finest resolution
  // that covers them.
  Json RowsOf(const procgen::v1::Pool& pool, int32_t span_s) const;
  // At most `count` mean returns of the last hour, oldest first.
  Json ReturnsOf(const procgen::v1::Pool& pool, size_t count) const;

 private:
  static constexpr size_t kValueCount = 9;  // of pools with one game
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

  struct Row {
    double time_s = 0;
    double step_count = 0;
    std::array<float, kValueCount> values = {};
    std::vector<float> game_returns;
  };
  // Rows of one resolution.
  struct Series {
    std::deque<Row> rows;
    std::vector<Row> pending;  // finer rows of the interval that is not complete
  };
  // Names are unique per owner only, and may be reused, so the creation time is stored.
  struct Course {
    double create_time_s = 0;
    double last_step_time_s = std::numeric_limits<double>::quiet_NaN();
    std::vector<std::string> games;  // if there are several
    std::array<Series, kResolutions.size()> series;
  };
  using Key = std::pair<std::string, std::string>;  // owner, name

  static Key KeyOf(const procgen::v1::Pool& pool) { return {pool.owner(), pool.name()}; }
  const Course* Find(const procgen::v1::Pool& pool) const;
  static void AddReport(double time_s, const PoolReport& report, Course* course);
  // Adds a row to the resolution, and to the coarser ones when their intervals are complete.
  static void AddRow(Row row, size_t resolution, Course* course);
  static Row Combine(const std::vector<Row>& rows);
  static size_t ResolutionFor(int32_t span_s);
  // The rows of the last `span_s` seconds: those of a resolution, followed by finer ones for the
  // interval that is not complete.
  static std::vector<const Row*> SelectRows(const Course& course, int32_t span_s);

  std::map<Key, Course> courses_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_POOL_HISTORY_H_
