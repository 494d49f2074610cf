#include "server/rpc/run/frame_buffer_pool.h"

#include <algorithm>
#include <memory>

#include "gtest/gtest.h"

namespace procgen {
namespace {

TEST(FrameBufferPoolTest, MemoryIsReusedAfterTheLastSliceCopy) {
  FrameBufferPool pool;
  Frames frames = pool.Take(1000);
  const uint8_t* const memory = frames.bytes.data();
  grpc::Slice copy = frames.slice;
  frames = {};
  EXPECT_NE(pool.Take(1000).bytes.data(), memory) << "in use by the copy";
  copy = grpc::Slice();
  EXPECT_EQ(pool.Take(1000).bytes.data(), memory);
  EXPECT_EQ(pool.Take(10).bytes.data(), memory) << "reused for a smaller size";
  EXPECT_EQ(pool.Take(2000).bytes.size(), 2000U);
}

TEST(FrameBufferPoolTest, SlicesOutliveThePool) {
  auto pool = std::make_unique<FrameBufferPool>();
  const Frames frames = pool->Take(1000);
  pool = nullptr;
  std::fill(frames.bytes.begin(), frames.bytes.end(), 1);
  EXPECT_EQ(*frames.slice.begin(), 1);
}

}  // namespace
}  // namespace procgen
