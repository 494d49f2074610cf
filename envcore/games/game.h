#ifndef ENVCORE_GAMES_GAME_H_
#define ENVCORE_GAMES_GAME_H_

#include <cstdint>

namespace procgen {

// How levels are made. The numbers are the released benchmark's. kExploration is a name for one
// hard level per game.
enum class DistributionMode : int32_t {
  kEasy = 0,
  kHard = 1,
  kExtreme = 2,
  kMemory = 10,
  kExploration = 20,
};

// Actions are in [0, kActionCount); kEndEpisodeAction does nothing and ends the episode.
inline constexpr int32_t kActionCount = 15;
inline constexpr int32_t kEndEpisodeAction = -1;
inline constexpr int32_t kNoAction = 4;

}  // namespace procgen

#endif  // ENVCORE_GAMES_GAME_H_
