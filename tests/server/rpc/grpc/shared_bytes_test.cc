#include "server/rpc/grpc/shared_bytes.h"

#include <string>
#include <vector>

#include "grpcpp/support/slice.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

grpc::ByteBuffer BufferOf(const std::vector<std::string>& pieces) {
  std::vector<grpc::Slice> slices(pieces.begin(), pieces.end());
  return {slices.data(), slices.size()};
}

std::string TextOf(const grpc::ByteBuffer& buffer) {
  grpc::Slice slice;
  EXPECT_TRUE(buffer.DumpToSingleSlice(&slice).ok());
  return {reinterpret_cast<const char*>(slice.begin()), slice.size()};
}

TEST(SharedBytesTest, BytesRoundTrip) {
  const std::string large(100'000, 'x');
  for (const std::vector<std::string>& pieces :
       {std::vector<std::string>{"short"}, std::vector<std::string>{large, "", "short", large}}) {
    std::string whole;
    for (const std::string& piece : pieces) {
      whole += piece;
    }
    const absl::Cord cord = CordOf(BufferOf(pieces));
    EXPECT_EQ(cord, whole);
    EXPECT_EQ(TextOf(ByteBufferOf(cord)), whole);
  }
}

TEST(SharedBytesTest, NoSizeIsCopied) {
  const grpc::ByteBuffer buffer = BufferOf({std::string(100'000, 'x')});
  std::vector<grpc::Slice> slices;
  ASSERT_TRUE(buffer.Dump(&slices).ok());
  const auto* memory = reinterpret_cast<const char*>(slices.front().begin());
  const absl::Cord cord = CordOf(buffer);
  EXPECT_EQ(cord.TryFlat()->data(), memory);
  ASSERT_TRUE(ByteBufferOf(cord).Dump(&slices).ok());
  EXPECT_EQ(reinterpret_cast<const char*>(slices.front().begin()), memory);
}

TEST(SharedBytesTest, BytesOutliveTheirSource) {
  absl::Cord cord = CordOf(BufferOf({std::string(1000, 'x')}));
  const grpc::ByteBuffer buffer = ByteBufferOf(cord);
  cord.Clear();
  EXPECT_EQ(TextOf(buffer), std::string(1000, 'x'));
}

// A short Cord stores its bytes inline.
TEST(SharedBytesTest, FewBytesOutliveTheirSource) {
  absl::Cord cord("short");
  const grpc::ByteBuffer buffer = ByteBufferOf(cord);
  cord = absl::Cord("other");
  EXPECT_EQ(TextOf(buffer), "short");
}

}  // namespace
}  // namespace procgen
