#include "envcore/render/art/art_pack.h"

#include <algorithm>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "envcore/art/embedded_art.h"
#include "envcore/render/art/png_decoding.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/render/one_colour_png.h"

namespace procgen {
namespace {

std::string TranslucentPng() { return OneColourPng(1, 1, Rgba{200, 100, 50, 128}); }

constexpr ArtSlot kSlot = {0, 3, "fish", "misc_assets/fish.png", 1, 1};

TEST(ArtPackTest, FindsImagesOfOurLayoutByGameSlotAndTheme) {
  const std::string png = TranslucentPng();
  const ArtPack pack(ArtLayout::kOwn, {{"bigfish/fish_3", png}});
  ASSERT_NE(pack.Sprite("bigfish", kSlot), nullptr);
  EXPECT_EQ(pack.Sprite("miner", kSlot), nullptr);
}

TEST(ArtPackTest, FindsImagesOfUpstreamsLayoutByPath) {
  const std::string png = TranslucentPng();
  const ArtPack pack(ArtLayout::kUpstream, {{"misc_assets/fish.png", png}});
  EXPECT_NE(pack.Sprite("bigfish", kSlot), nullptr);
}

TEST(ArtPackTest, SpritesArePremultipliedAndBackgroundsOpaque) {
  const std::string png = TranslucentPng();
  const ArtPack pack(ArtLayout::kUpstream, {{"misc_assets/fish.png", png}});
  EXPECT_EQ(pack.Sprite("bigfish", kSlot)->level(0).At(0, 0),
            (Rgba{Mul(200, 128), Mul(100, 128), Mul(50, 128), 128}));
  EXPECT_EQ(pack.Background({"x", "misc_assets/fish.png"})->level(0).At(0, 0),
            (Rgba{200, 100, 50, 255}));
}

TEST(ArtPackTest, InvalidFilesCountAsMissing) {
  const std::string cut = TranslucentPng().substr(0, 50);
  const ArtPack pack(ArtLayout::kOwn, {{"a/fish_3", cut}, {"b/fish_3", "no PNG"}});
  EXPECT_EQ(pack.Sprite("a", kSlot), nullptr);
  EXPECT_EQ(pack.Sprite("b", kSlot), nullptr);
}

TEST(ArtPackTest, ConcurrentRequestsGetTheSameImage) {
  const std::string png = TranslucentPng();
  const ArtPack pack(ArtLayout::kOwn, {{"bigfish/fish_3", png}});
  std::vector<const MipmappedImage*> pictures(8);
  std::vector<std::thread> threads;
  threads.reserve(pictures.size());
  for (const MipmappedImage*& picture : pictures) {
    threads.emplace_back([&] { picture = pack.Sprite("bigfish", kSlot); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_NE(pictures[0], nullptr);
  EXPECT_THAT(pictures, ::testing::Each(pictures[0]));
}

TEST(ArtPackTest, EveryEmbeddedImageCanBeDecoded) {
  const std::vector<EmbeddedFile> files = EmbeddedArt();
  EXPECT_FALSE(files.empty());
  for (const EmbeddedFile& file : files) {
    EXPECT_TRUE(DecodePng(file.png, AlphaUse::kPremultiplied).ok()) << file.name;
  }
}

TEST(ArtPackTest, EmbeddedPackHasEveryBackground) {
  for (const BackgroundGroup group :
       {BackgroundGroup::kPlatform, BackgroundGroup::kSpace, BackgroundGroup::kTopdown,
        BackgroundGroup::kTopdownSimple, BackgroundGroup::kWater, BackgroundGroup::kWaterSurface}) {
    for (const BackgroundSlot& slot : BackgroundsOf(group)) {
      const MipmappedImage* picture = ArtPack::Embedded()->Background(slot);
      ASSERT_NE(picture, nullptr) << slot.name;
      EXPECT_GE(picture->level(0).width(), picture->level(0).height()) << slot.name;
    }
  }
}

TEST(ArtPackTest, EmbeddedPackHasEverySharedSprite) {
  for (const ArtSlot& slot : SharedArtSlots()) {
    EXPECT_NE(ArtPack::Embedded()->Sprite("shared", slot), nullptr) << slot.name;
  }
}

}  // namespace
}  // namespace procgen
