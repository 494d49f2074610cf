#ifndef CLIENTS_TOP_SCREEN_H_
#define CLIENTS_TOP_SCREEN_H_

#include <string>
#include <vector>

#include "clients/top/sample.h"

namespace procgen_top {

// What is shown of a server, as lines of text without control characters: how busy it is, what a
// request took, then the nodes of its cluster and the caller's pools, the busiest first. Rates and
// latencies are those between `before` and `now`. `title` is the first line.
std::vector<std::string> ScreenOf(const std::string& title, const Sample& before,
                                  const Sample& now);

}  // namespace procgen_top

#endif  // CLIENTS_TOP_SCREEN_H_
