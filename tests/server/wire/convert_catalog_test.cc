#include "server/wire/convert_catalog.h"

#include <set>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen/v1/pools.pb.h"

namespace procgen {
namespace {

TEST(ConvertCatalogTest, AllSixteenGamesAreListedInOrder) {
  const v1::Catalog catalog = CatalogMessageOf({.version = "1.2.3"}, Limits());
  EXPECT_EQ(catalog.server_version(), "1.2.3");
  ASSERT_EQ(catalog.games_size(), 16);
  for (int i = 1; i < catalog.games_size(); ++i) {
    EXPECT_LT(catalog.games(i - 1).name(), catalog.games(i).name());
  }
}

TEST(ConvertCatalogTest, MazeHasItsModesAndConstants) {
  const v1::Catalog catalog = CatalogMessageOf({}, Limits());
  for (const v1::Game& game : catalog.games()) {
    if (game.name() != "maze") {
      continue;
    }
    EXPECT_EQ(game.action_count(), 15);
    ASSERT_EQ(game.modes_size(), 4);
    EXPECT_EQ(game.modes(0).distribution_mode(), v1::DISTRIBUTION_MODE_EASY);
    EXPECT_EQ(game.modes(0).time_limit_steps(), 500);
    EXPECT_EQ(game.modes(0).return_range().min(), 5);
    EXPECT_EQ(game.modes(0).return_range().max(), 10);
    EXPECT_EQ(game.modes(3).distribution_mode(), v1::DISTRIBUTION_MODE_EXPLORATION);
    EXPECT_EQ(game.modes(3).level_seed(), 158988835);
  }
}

TEST(ConvertCatalogTest, SpecialActionsAreThoseOfTheGame) {
  const v1::Catalog catalog = CatalogMessageOf({}, Limits());
  for (int i = 0; i < catalog.games_size(); ++i) {
    const v1::Game& game = catalog.games(i);
    const absl::Span<const SpecialAction> expected = FindGame(game.name())->special_actions;
    ASSERT_EQ(game.special_actions_size(), static_cast<int>(expected.size())) << game.name();
    for (int j = 0; j < game.special_actions_size(); ++j) {
      EXPECT_EQ(game.special_actions(j).action(), expected[static_cast<size_t>(j)].action);
      EXPECT_EQ(game.special_actions(j).description(),
                expected[static_cast<size_t>(j)].description);
    }
  }
}

TEST(ConvertCatalogTest, OptionsAreTheFieldsOfTheMessage) {
  const v1::Catalog catalog = CatalogMessageOf({}, Limits());
  const auto* fields = v1::EnvironmentOptions::descriptor();
  ASSERT_EQ(catalog.options_size(), fields->field_count());
  for (int i = 0; i < fields->field_count(); ++i) {
    EXPECT_EQ(catalog.options(i).name(), fields->field(i)->name());
  }
}

TEST(ConvertCatalogTest, ArtIsReportedWithoutItsFolder) {
  EXPECT_EQ(CatalogMessageOf({}, Limits()).art(), "built-in");
  EXPECT_EQ(CatalogMessageOf({.has_own_art = true}, Limits()).art(), "folder");
}

TEST(ConvertCatalogTest, LimitsAreReported) {
  Limits limits;
  limits.env_count_max = 1;
  limits.owner_env_count_max = 2;
  limits.owner_bytes_max = 3;
  limits.owner_call_count_max = 4;
  limits.request_bytes_max = 5;
  limits.response_bytes_max = 6;
  limits.episode_history_bytes_max = 7;
  const v1::Catalog catalog = CatalogMessageOf({}, limits);
  EXPECT_EQ(catalog.limits().env_count_max(), 1);
  EXPECT_EQ(catalog.limits().owner_env_count_max(), 2);
  EXPECT_EQ(catalog.limits().owner_bytes_max(), 3);
  EXPECT_EQ(catalog.limits().owner_call_count_max(), 4);
  EXPECT_EQ(catalog.limits().request_bytes_max(), 5);
  EXPECT_EQ(catalog.limits().response_bytes_max(), 6);
  EXPECT_EQ(catalog.limits().episode_history_bytes_max(), 7);
}

TEST(ConvertCatalogTest, ObservationFormatsAreReported) {
  const v1::Catalog catalog = CatalogMessageOf({}, Limits());
  EXPECT_THAT(catalog.colors(), testing::ElementsAre(v1::COLOR_RGB, v1::COLOR_GRAYSCALE));
  EXPECT_THAT(catalog.layouts(), testing::ElementsAre(v1::LAYOUT_HWC, v1::LAYOUT_CHW));
  EXPECT_EQ(catalog.limits().observation_size_px_min(), 16);
  EXPECT_EQ(catalog.limits().observation_size_px_max(), 512);
  EXPECT_EQ(catalog.limits().frame_stack_max(), 16);
}

TEST(ConvertCatalogTest, ActionsNameTheirKeys) {
  const v1::Catalog catalog = CatalogMessageOf({}, Limits());
  ASSERT_EQ(catalog.actions_size(), 15);
  EXPECT_THAT(catalog.actions(0).keys(), testing::ElementsAre("LEFT", "DOWN"));
  EXPECT_TRUE(catalog.actions(4).keys().empty());
  EXPECT_EQ(catalog.actions(4).name(), "NONE");
  EXPECT_EQ(catalog.actions(14).name(), "E");
}

}  // namespace
}  // namespace procgen
