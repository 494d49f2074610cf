#include "server/rpc/step/frame_buffer_pool.h"

#include <algorithm>
#include <memory>

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(FrameBufferPoolTest, SliceContainsTheWrittenBytes) {
  FrameBufferPool ring;
  const Frames frames = ring.Take(100000);
  ASSERT_EQ(frames.slice.size(), 100000U);
  ASSERT_EQ(frames.bytes.size(), 100000U);
  std::fill(frames.bytes.begin(), frames.bytes.end(), 7);
  EXPECT_EQ(frames.slice.begin(), frames.bytes.data());
  EXPECT_EQ(*(frames.slice.end() - 1), 7);
}

TEST(FrameBufferPoolTest, ZeroBytesGiveAnEmptySlice) {
  EXPECT_EQ(FrameBufferPool().Take(0).slice.size(), 0U);
}

TEST(FrameBufferPoolTest, MemoryIsReusedAfterTheLastSliceCopy) {
  FrameBufferPool ring;
  Frames frames = ring.Take(1000);
  const uint8_t* const memory = frames.bytes.data();
  grpc::Slice copy = frames.slice;
  frames = {};
  EXPECT_NE(ring.Take(1000).bytes.data(), memory) << "the copy holds the memory";
  copy = grpc::Slice();
  EXPECT_EQ(ring.Take(1000).bytes.data(), memory);
  EXPECT_EQ(ring.Take(10).bytes.data(), memory) << "also for fewer bytes";
  EXPECT_EQ(ring.Take(2000).bytes.size(), 2000U);
}

TEST(FrameBufferPoolTest, SlicesOutliveThePool) {
  auto ring = std::make_unique<FrameBufferPool>();
  const Frames frames = ring->Take(1000);
  ring = nullptr;
  std::fill(frames.bytes.begin(), frames.bytes.end(), 1);
  EXPECT_EQ(*frames.slice.begin(), 1);
}

}  // namespace
}  // namespace procgen
