#ifndef SERVER_POOL_REPORTS_H_
#define SERVER_POOL_REPORTS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/rpc/server.h"
#include "server/web/web_server.h"

namespace procgen {

// What the pages show of a server's pools, and do with them, and the API does not have.

// The pools of all owners.
std::vector<web::PoolReport> ReportPools(const Server& server);
// The last episodes of a pool, without the first `after`. Empty if there is no such pool.
web::EpisodeList ReportEpisodes(const Server& server, const std::string& owner,
                                const std::string& name, int64_t after);
// Pauses a pool; null if there is none.
std::unique_ptr<web::PoolPause> PausePool(const Server& server, const std::string& owner,
                                          const std::string& name);

}  // namespace procgen

#endif  // SERVER_POOL_REPORTS_H_
