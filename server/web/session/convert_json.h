#ifndef SERVER_WEB_SESSION_CONVERT_JSON_H_
#define SERVER_WEB_SESSION_CONVERT_JSON_H_

#include <vector>

#include "google/protobuf/timestamp.pb.h"
#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/cluster.pb.h"
#include "procgen/v1/pools.pb.h"
#include "server/web/json/message.h"
#include "server/web/session/pool_report.h"

namespace procgen::web {

// API messages as JSON; server/web/json/README.md lists the members.

Json CatalogJson(const procgen::v1::Catalog& catalog);
// Without the members that the history provides.
Json PoolJson(const procgen::v1::Pool& pool);
// Each episode is a row of the columns in the answer of pool.episodes.
Json EpisodesJson(const procgen::v1::Pool& pool, const EpisodeList& list);
Json NodesJson(const procgen::v1::ListNodesResponse& nodes);
// Counts of pools, environments and streams are those of `pools`, without pools of pages, like
// `steps_per_second`.
Json LoadJson(const procgen::v1::Load& load, const std::vector<PoolReport>& pools,
              double steps_per_second);

// Seconds since 1970.
double SecondsOf(const google::protobuf::Timestamp& time);

// Values that the history also contains; null if there is none yet.
Json MeanReturnJson(const procgen::v1::Pool& pool);
Json MeanLengthJson(const procgen::v1::Pool& pool);
Json RequestP50MsJson(const procgen::v1::Pool& pool);
Json RequestP99MsJson(const procgen::v1::Pool& pool);

}  // namespace procgen::web

#endif  // SERVER_WEB_SESSION_CONVERT_JSON_H_
