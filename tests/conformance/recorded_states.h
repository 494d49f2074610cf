#ifndef TESTS_CONFORMANCE_RECORDED_STATES_H_
#define TESTS_CONFORMANCE_RECORDED_STATES_H_

#include <string>
#include <vector>

#include "envcore/games/game.h"
#include "nlohmann/json.hpp"

namespace procgen {

// Reads a gzipped file with one JSON object per line. Ends the program if the file cannot be read.
std::vector<nlohmann::json> ReadGzippedJsonLines(const std::string& path);

// The state of `game` in the format of the recorded states, as far as they can be compared: time,
// world, background, background_offset, step_int, entities and, with_grid, grid (rows from the
// bottom up, run-length encoded).
nlohmann::json StateOf(const Game& game, bool with_grid);

}  // namespace procgen

#endif  // TESTS_CONFORMANCE_RECORDED_STATES_H_
