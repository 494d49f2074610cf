#include "server/session/pool/answer_cache.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using testing::ElementsAre;

TEST(AnswerCacheTest, KeptAnswerHasAllItsResponses) {
  AnswerCache kept;
  kept.Keep(7, {absl::Cord("a"), absl::Cord("b")});
  ASSERT_NE(kept.Find(7), nullptr);
  EXPECT_THAT(*kept.Find(7), ElementsAre("a", "b"));
  EXPECT_EQ(kept.Find(6), nullptr);
  EXPECT_EQ(kept.Find(8), nullptr);
}

TEST(AnswerCacheTest, DropRemovesAllUpToANumber) {
  AnswerCache kept;
  for (const int64_t number : {3, 4, 5}) {
    kept.Keep(number, {absl::Cord("x")});
  }
  kept.ForgetUpTo(2);
  EXPECT_EQ(kept.Range(), "3 to 5");
  kept.ForgetUpTo(4);
  EXPECT_EQ(kept.Find(4), nullptr);
  EXPECT_NE(kept.Find(5), nullptr);
  EXPECT_EQ(kept.OldestOr(9), 5);
  kept.ForgetUpTo(5);
  EXPECT_EQ(kept.Range(), "none");
  EXPECT_EQ(kept.OldestOr(9), 9);
}

}  // namespace
}  // namespace procgen
