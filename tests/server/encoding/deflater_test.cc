#include "server/encoding/deflater.h"

#include <zlib.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

using testing::Lt;

constexpr size_t kFrameBytes = 64 * 64 * 3;

std::vector<uint8_t> NoiseBytes(size_t size, unsigned seed) {
  std::minstd_rand random(seed);
  std::vector<uint8_t> bytes(size);
  for (uint8_t& byte : bytes) {
    byte = static_cast<uint8_t>(random() >> 8);
  }
  return bytes;
}

// A block that is not compressed.
std::string StoredBlock(const std::vector<uint8_t>& bytes) {
  const size_t size = bytes.size();
  std::string block(5, '\0');
  block[1] = static_cast<char>(size);
  block[2] = static_cast<char>(size >> 8);
  block[3] = static_cast<char>(~size);
  block[4] = static_cast<char>(~size >> 8);
  return block.append(bytes.begin(), bytes.end());
}

// Reads blocks, of which the last may be missing.
std::vector<uint8_t> Inflate(const std::string& blocks, size_t size) {
  z_stream stream = {};
  EXPECT_EQ(inflateInit2(&stream, -15), Z_OK);
  std::vector<uint8_t> bytes(size + 1);
  std::string input = blocks;
  stream.next_in = reinterpret_cast<Bytef*>(input.data());
  stream.avail_in = static_cast<uInt>(input.size());
  stream.next_out = bytes.data();
  stream.avail_out = static_cast<uInt>(bytes.size());
  EXPECT_EQ(inflate(&stream, Z_SYNC_FLUSH), Z_OK);
  EXPECT_EQ(stream.avail_in, 0U);
  bytes.resize(stream.total_out);
  inflateEnd(&stream);
  return bytes;
}

TEST(DeflaterTest, BytesRoundTripAfterTheDictionaryAsAStoredBlock) {
  Deflater deflater;
  const std::vector<uint8_t> before = NoiseBytes(kFrameBytes, 1);
  std::vector<uint8_t> now = before;
  now[5000] ^= 1U;
  const std::string blocks = deflater.Deflate(now, before);
  EXPECT_THAT(blocks.size(), Lt(200U));
  std::vector<uint8_t> both = before;
  both.insert(both.end(), now.begin(), now.end());
  EXPECT_EQ(Inflate(StoredBlock(before) + blocks, 2 * kFrameBytes), both);
}

TEST(DeflaterTest, BlocksOfSeveralCallsCanBeConcatenated) {
  Deflater deflater;
  const std::vector<uint8_t> first(kFrameBytes, 7);
  const std::vector<uint8_t> second = NoiseBytes(kFrameBytes, 2);
  std::vector<uint8_t> both = first;
  both.insert(both.end(), second.begin(), second.end());
  const std::string blocks = deflater.Deflate(first, {});
  EXPECT_EQ(Inflate(blocks + deflater.Deflate(second, {}), 2 * kFrameBytes), both);
}

TEST(DeflaterTest, IncompressibleBytesFit) {
  Deflater deflater;
  for (const size_t size : {1U, 100U, 12288U, 70000U}) {
    const std::vector<uint8_t> bytes = NoiseBytes(size, 3);
    EXPECT_EQ(Inflate(deflater.Deflate(bytes, NoiseBytes(size, 4)), size).size(), size);
    EXPECT_EQ(Inflate(deflater.Deflate(bytes, {}), size), bytes);
  }
}

}  // namespace
}  // namespace procgen
