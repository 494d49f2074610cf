#include "server/wire/convert_catalog.h"

#include <set>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen/v1/pools.pb.h"

namespace procgen {
namespace {

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

TEST(ConvertCatalogTest, EachGameHasItsVariants) {
  const v1::Catalog catalog = CatalogMessageOf({}, Limits());
  for (const v1::Game& game : catalog.games()) {
    std::vector<std::string> names;
    for (const v1::Variant& variant : game.variants()) {
      names.push_back(variant.name());
      EXPECT_FALSE(variant.description().empty());
    }
    if (game.name() == "coinrun") {
      EXPECT_THAT(names, testing::ElementsAre("coin_random", "gravity=0.2", "jump_speed=1.5"));
    } else if (game.name() == "maze") {
      EXPECT_THAT(names, testing::ElementsAre("cheese_corner", "two_objects"));
    } else if (game.name() == "heist") {
      EXPECT_THAT(names, testing::IsEmpty());
    }
  }
  EXPECT_THAT(catalog.options(catalog.options_size() - 1).names(),
              testing::ElementsAre("coin_random", "cheese_corner", "two_objects", "gravity=0.2",
                                   "gravity=0.15", "jump_speed=1.5", "jump_speed=1",
                                   "enemy_speed=0.05", "thrust_speed=0.45"));
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

}  // namespace
}  // namespace procgen
