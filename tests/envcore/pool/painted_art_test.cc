// Paints the folder that other tests, which know no engine, draw with; and shows that it is one.

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
