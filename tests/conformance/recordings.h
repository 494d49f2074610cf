#ifndef TESTS_CONFORMANCE_RECORDINGS_H_
#define TESTS_CONFORMANCE_RECORDINGS_H_

#include <string>
#include <vector>

namespace procgen {

// The folders with recordings of Procgen 0.10.7 and with its art, next to the checkout; an empty
// string if there is no such folder.
std::string ReferenceFolder();
std::string UpstreamArtFolder();

// The paths of the recordings in a folder, sorted; empty if there is no such folder.
std::vector<std::string> TracesIn(const std::string& folder);
// The paths of the recordings of one game. File names begin with the name of the game.
std::vector<std::string> TracesOf(const std::string& game, const std::string& folder);

// The names of all games.
std::vector<std::string> GamesOfTheCatalog();

}  // namespace procgen

#endif  // TESTS_CONFORMANCE_RECORDINGS_H_
