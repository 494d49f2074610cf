#ifndef TESTS_CONFORMANCE_RECORDINGS_H_
#define TESTS_CONFORMANCE_RECORDINGS_H_

#include <string>
#include <vector>

namespace procgen {

// The folder of recordings of Procgen 0.10.7 beside a checkout, and that of its art; an
// empty text where there is none.
std::string ReferenceFolder();
std::string UpstreamArtFolder();

// The recordings in a folder, sorted; none where there is no such folder.
std::vector<std::string> TracesIn(const std::string& folder);
// Those whose file name begins with that of the game.
std::vector<std::string> TracesOf(const std::string& game, const std::string& folder);

// The names of all games.
std::vector<std::string> GamesOfTheCatalog();

}  // namespace procgen

#endif  // TESTS_CONFORMANCE_RECORDINGS_H_
