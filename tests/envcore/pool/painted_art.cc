#include "tests/envcore/pool/painted_art.h"

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "envcore/pool/upstream_images.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/one_colour_png.h"

namespace procgen {
namespace {

// Backgrounds, which may have any size, are twice as wide as high.
constexpr int kBackgroundWidthPx = 16;
constexpr int kBackgroundHeightPx = 8;

}  // namespace

void PaintArtFolder(const std::string& folder) {
  uint32_t number = 0;
  for (const RequiredImage& picture : UpstreamImages()) {
    const auto path = std::filesystem::path(folder) / std::string(picture.path);
    std::filesystem::create_directories(path.parent_path());
    const bool any_size = picture.width_px == 0;
    // Neighbors in the list get very different colors.
    const uint32_t mixed = ++number * 2654435761U;
    const Rgba colour = {static_cast<uint8_t>(mixed >> 24), static_cast<uint8_t>(mixed >> 16),
                         static_cast<uint8_t>(mixed >> 8), 255};
    std::ofstream file(path, std::ios::binary);
    file << OneColourPng(any_size ? kBackgroundWidthPx : picture.width_px,
                         any_size ? kBackgroundHeightPx : picture.height_px, colour);
    file.close();
    EXPECT_TRUE(file.good()) << path;
  }
}

}  // namespace procgen
