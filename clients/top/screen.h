#ifndef CLIENTS_TOP_SCREEN_H_
#define CLIENTS_TOP_SCREEN_H_

#include <string>
#include <vector>

#include "clients/top/sample.h"

namespace procgen_top {

// Formats a screen as lines of text without control characters: `title`, load and latencies, the
// nodes of the cluster, and the caller's pools, the busiest first. Rates and latencies are of the
// time between `before` and `now`.
std::vector<std::string> ScreenOf(const std::string& title, const Sample& before,
                                  const Sample& now);

}  // namespace procgen_top

#endif  // CLIENTS_TOP_SCREEN_H_
