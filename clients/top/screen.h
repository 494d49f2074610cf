#ifndef CLIENTS_TOP_SCREEN_H_
#define CLIENTS_TOP_SCREEN_H_

#include <string>
#include <vector>

#include "clients/top/pool_table.h"
#include "clients/top/rate_history.h"
#include "clients/top/sample.h"

namespace procgen_top {

// How a line is shown on a terminal.
enum class Style { kPlain, kTitle, kTableHead, kWarning, kOutdated };

struct Line {
  std::string text;  // UTF-8 without control characters
  Style style = Style::kPlain;
};

struct Screen {
  std::vector<Line> head;   // title, load and latencies, the nodes of the cluster, the table's head
  std::vector<Line> pools;  // a line for each of the caller's pools
};

// Formats a screen. Rates and latencies are of the time between `before` and `now`, which `history`
// has, too.
Screen ScreenOf(const std::string& title, const Sample& before, const Sample& now,
                const RateHistory& history, const PoolTableOptions& options);

}  // namespace procgen_top

#endif  // CLIENTS_TOP_SCREEN_H_
