#ifndef SERVER_WIRE_CONVERT_EPISODE_H_
#define SERVER_WIRE_CONVERT_EPISODE_H_

#include <cstdint>

#include "envcore/pool/pool.h"
#include "procgen/v1/episodes.pb.h"
#include "server/pool/episodes/episode.h"
#include "server/pool/episodes/recent_episodes.h"

namespace procgen {

// Converts an episode of `environment`, of a pool with options `pool`, to a message.
void FillEpisode(const Episode& episode, const PoolOptions& pool, int32_t environment,
                 v1::Episode* message);

// Converts a list of ended episodes.
void FillEpisodeList(const RecentEpisodes::List& list, v1::ListEpisodesResponse* message);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_EPISODE_H_
