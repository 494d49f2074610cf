#ifndef TESTS_ENVCORE_POOL_PAINTED_ART_H_
#define TESTS_ENVCORE_POOL_PAINTED_ART_H_

#include <string>

namespace procgen {

// Fills a folder, which is made if need be, with art in the layout of Procgen 0.10.7: every picture
// that a game can show, by its upstream name and in its size, but of one color. A program that
// loads it has all that it asks of a folder. Fails the test if the disk does.
void PaintArtFolder(const std::string& folder);

}  // namespace procgen

#endif  // TESTS_ENVCORE_POOL_PAINTED_ART_H_
