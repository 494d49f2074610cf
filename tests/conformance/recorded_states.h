#ifndef TESTS_CONFORMANCE_RECORDED_STATES_H_
#define TESTS_CONFORMANCE_RECORDED_STATES_H_

#include <string>
#include <vector>

#include "envcore/games/game.h"
#include "nlohmann/json.hpp"

namespace procgen {

// The lines of a gzipped file, each a JSON object. Ends the program if the file cannot be read.
std::vector<nlohmann::json> ReadGzippedJsonLines(const std::string& path);

// The state of `game` in the form of the recorded ones that can be compared: time, world,
// background, background_offset, step_int, entities and, with_grid, grid (rows from the bottom up,
// run-length coded).
nlohmann::json StateOf(const Game& game, bool with_grid);

}  // namespace procgen

#endif  // TESTS_CONFORMANCE_RECORDED_STATES_H_
