#include "server/web/session/difference_cache.h"

#include <cstddef>
#include <optional>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen::web {
namespace {

using testing::Optional;

TEST(DifferenceCacheTest, FindsDifferencesByBothFrames) {
  DifferenceCache differences;
  differences.Add({1, 2}, "from 1 to 2");
  differences.Add({2, 1}, "from 2 to 1");
  EXPECT_THAT(differences.Find({1, 2}), Optional(std::string("from 1 to 2")));
  EXPECT_THAT(differences.Find({2, 1}), Optional(std::string("from 2 to 1")));
  EXPECT_EQ(differences.Find({1, 1}), std::nullopt);
}

TEST(DifferenceCacheTest, DropsTheOldestBeyondItsLimit) {
  DifferenceCache differences;
  const std::string difference(DifferenceCache::kBytesMax / 4, 'x');
  for (size_t i = 0; i < 4; ++i) {
    differences.Add({i, i}, difference);
    differences.Add({i, i}, difference);  // again, by another page
  }
  EXPECT_EQ(differences.count(), 3);  // their keys take memory, too
  EXPECT_EQ(differences.Find({0, 0}), std::nullopt);
  EXPECT_THAT(differences.Find({1, 1}), Optional(difference));
  EXPECT_THAT(differences.Find({3, 3}), Optional(difference));
}

}  // namespace
}  // namespace procgen::web
