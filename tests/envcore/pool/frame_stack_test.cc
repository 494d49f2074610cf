#include "envcore/pool/frame_stack.h"

#include <algorithm>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using ::testing::ElementsAre;

// Pushes a frame of two bytes with this value.
void Push(FrameStack& stack, uint8_t value) {
  const absl::Span<uint8_t> frame = stack.Next();
  ASSERT_EQ(frame.size(), 2U);
  std::fill(frame.begin(), frame.end(), value);
}

std::vector<uint8_t> Shown(const FrameStack& stack, size_t depth) {
  std::vector<uint8_t> observation(2 * depth);
  stack.CopyTo(absl::MakeSpan(observation));
  return observation;
}

TEST(FrameStackTest, BeginsEmpty) { EXPECT_TRUE(FrameStack(2, 3).empty()); }

TEST(FrameStackTest, TheFirstFrameFillsTheMissingPlaces) {
  FrameStack stack(2, 3);
  Push(stack, 1);
  EXPECT_FALSE(stack.empty());
  EXPECT_THAT(Shown(stack, 3), ElementsAre(1, 1, 1, 1, 1, 1));
  Push(stack, 2);
  EXPECT_THAT(Shown(stack, 3), ElementsAre(1, 1, 1, 1, 2, 2));
}

TEST(FrameStackTest, TheOldestFrameIsReplacedFirst) {
  FrameStack stack(2, 3);
  for (uint8_t value = 1; value <= 7; ++value) {
    Push(stack, value);
  }
  EXPECT_THAT(Shown(stack, 3), ElementsAre(5, 5, 6, 6, 7, 7));
}

TEST(FrameStackTest, AClearedStackRestartsAtAnyPosition) {
  for (uint8_t before = 0; before < 7; ++before) {
    FrameStack stack(2, 3);
    for (uint8_t value = 0; value < before; ++value) {
      Push(stack, value);
    }
    stack.Clear();
    EXPECT_TRUE(stack.empty());
    Push(stack, 8);
    EXPECT_THAT(Shown(stack, 3), ElementsAre(8, 8, 8, 8, 8, 8));
    Push(stack, 9);
    EXPECT_THAT(Shown(stack, 3), ElementsAre(8, 8, 8, 8, 9, 9));
  }
}

}  // namespace
}  // namespace procgen
