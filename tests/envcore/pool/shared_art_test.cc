#include "envcore/pool/shared_art.h"

#include <filesystem>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "envcore/games/game_catalog.h"
#include "envcore/render/art/art_pack.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/envcore/pool/painted_art.h"
#include "tests/envcore/pool/small_pool.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

TEST(SharedArtTest, PoolsShareTheArtOfAGame) {
  const GameSpec& game = *FindGame("maze");
  const std::unique_ptr<Game> first = game.make(GameOptions());
  const std::unique_ptr<Game> second = game.make(GameOptions());
  EXPECT_EQ(SharedArt::Embedded()->Of(game, first->art()),
            SharedArt::Embedded()->Of(game, second->art()));
}

TEST(SharedArtTest, EverySlotOfEveryGameHasABuiltInImage) {
  const std::shared_ptr<const ArtPack> pack = ArtPack::Embedded();
  for (const GameSpec& spec : GameCatalog()) {
    const std::unique_ptr<Game> game = spec.make(GameOptions());
    for (const ArtSlot& slot : game->art().slots) {
      EXPECT_NE(pack->Sprite(spec.name, slot), nullptr)
          << spec.name << "/" << slot.name << "_" << slot.theme;
    }
  }
}

// A folder of painted art for one test.
class PaintedFolder {
 public:
  PaintedFolder() { PaintArtFolder(path_); }
  ~PaintedFolder() { std::filesystem::remove_all(path_); }
  PaintedFolder(const PaintedFolder&) = delete;
  PaintedFolder& operator=(const PaintedFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  const std::string path_ = absl::StrCat(
      testing::TempDir(), "/shared_art_",
      absl::StrReplaceAll(testing::UnitTest::GetInstance()->current_test_info()->name(),
                          {{"/", "_"}}));
};

TEST(SharedArtTest, AFolderWithAMissingImageIsRejectedByName) {
  const PaintedFolder folder;
  std::filesystem::remove(folder.path() + "/misc_assets/fishTile_072.png");
  EXPECT_THAT(SharedArt::LoadFolder(folder.path()),
              StatusIs(absl::StatusCode::kNotFound,
                       testing::HasSubstr("1 of 329 images are missing or invalid: "
                                          "misc_assets/fishTile_072.png is missing")));
}

TEST(SharedArtTest, LoadedArtIsFreedWithItsLastPool) {
  const PaintedFolder folder;
  auto art = SharedArt::LoadFolder(folder.path());
  ASSERT_THAT(art, IsOk());
  const std::weak_ptr<const SharedArt> watched = *art;
  PoolOptions options = OptionsOf({"maze"});
  options.art = *std::move(art);
  std::unique_ptr<Pool> pool = MadePool(options);
  options.art = nullptr;
  Observed(*pool);
  EXPECT_FALSE(watched.expired());
  pool = nullptr;
  EXPECT_TRUE(watched.expired());
}

class ArtOfAGameTest : public testing::TestWithParam<std::string> {};

// Art facts are rules: they do not depend on the images.
TEST_P(ArtOfAGameTest, OtherArtChangesPixelsAndNothingElse) {
  constexpr int kSteps = 300;
  const PaintedFolder folder;
  PoolOptions options = OptionsOf({GetParam()});
  options.environment.rand_seed = 5;
  const std::unique_ptr<Pool> own = MadePool(options);
  const auto art = SharedArt::LoadFolder(folder.path());
  ASSERT_THAT(art, IsOk());
  options.art = *art;
  const std::unique_ptr<Pool> painted = MadePool(options);
  int differing_count = 0;
  for (int step = 0; step < kSteps; ++step) {
    std::vector<int32_t> actions(kEnvCount);
    for (int32_t i = 0; i < kEnvCount; ++i) {
      actions[static_cast<size_t>(i)] = (step / 4 * 7 + i * 3) % kActionCount;
    }
    BatchBuffers expected = Stepped(*own, actions);
    BatchBuffers got = Stepped(*painted, actions);
    differing_count += static_cast<int>(expected.observations != got.observations);
    expected.observations = got.observations;
    expected.final_observations = got.final_observations;
    ASSERT_EQ(expected, got) << "step " << step;
  }
  EXPECT_EQ(differing_count, kSteps);
}

std::vector<std::string> AllGames() {
  std::vector<std::string> names;
  for (const GameSpec& game : GameCatalog()) {
    names.emplace_back(game.name);
  }
  return names;
}

INSTANTIATE_TEST_SUITE_P(Catalog, ArtOfAGameTest, testing::ValuesIn(AllGames()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace procgen
