#ifndef TESTS_ENVCORE_POOL_PAINTED_ART_H_
#define TESTS_ENVCORE_POOL_PAINTED_ART_H_

#include <string>

namespace procgen {

// Fills a folder, which is created if needed, with art in the layout of Procgen 0.10.7: one image
// of a single color for every slot and background, with upstream's path and size.
// SharedArt::LoadFolder accepts the folder. Fails the test on I/O errors.
void PaintArtFolder(const std::string& folder);

}  // namespace procgen

#endif  // TESTS_ENVCORE_POOL_PAINTED_ART_H_
