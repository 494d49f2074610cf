// Paints the folder that tests without the engine use, and checks that it is a valid art folder.

#include "tests/envcore/pool/painted_art.h"

#include "envcore/pool/shared_art.h"
#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(PaintedArtTest, FolderHasEveryRequiredImage) {
  PaintArtFolder(PROCGEN_PAINTED_ART_DIR);
  EXPECT_THAT(SharedArt::LoadFolder(PROCGEN_PAINTED_ART_DIR), IsOk());
}

}  // namespace
}  // namespace procgen
