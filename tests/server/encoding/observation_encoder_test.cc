#include "server/encoding/observation_encoder.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "envcore/random/random_stream.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/observation_decoder.h"
#include "tests/status_matchers.h"
#include "zstd.h"

namespace procgen {
namespace {

using procgen_client::ObservationDecoder;
using testing::HasSubstr;
using Bytes = std::vector<uint8_t>;

constexpr size_t kObservation = 40;  // bytes of one, where the content is no picture

Bytes Noise(int64_t seed, size_t size) {
  RandomStream random(seed);
  Bytes bytes(size);
  for (uint8_t& byte : bytes) {
    byte = static_cast<uint8_t>(random.Int(256));
  }
  return bytes;
}

// The content of `encoded`, which must be exactly one zstd frame with content size.
Bytes ContentOf(const std::string& encoded) {
  const uint64_t size = ZSTD_getFrameContentSize(encoded.data(), encoded.size());
  EXPECT_LT(size, uint64_t{1} << 20) << "no zstd frame with content size";
  EXPECT_EQ(ZSTD_findFrameCompressedSize(encoded.data(), encoded.size()), encoded.size());
  Bytes content(size);
  EXPECT_EQ(ZSTD_decompress(content.data(), size, encoded.data(), encoded.size()), size);
  return content;
}

std::string FrameOf(const Bytes& content) {
  std::string frame(ZSTD_compressBound(content.size()), '\0');
  frame.resize(
      ZSTD_compress(frame.data(), frame.size(), content.data(), content.size(), /*level=*/1));
  return frame;
}

TEST(ObservationEncoderTest, FirstObservationsAreSentAsTheyAre) {
  ObservationEncoder encoder(3, kObservation);
  const Bytes observations = Noise(1, 3 * kObservation);
  EXPECT_EQ(ContentOf(encoder.Encode(0, 3, observations)), observations);
}

TEST(ObservationEncoderTest, LaterOnesAreDifferencesModulo256ToThoseOfTheirEnvironment) {
  ObservationEncoder encoder(3, kObservation);
  encoder.Encode(0, 3, Bytes(3 * kObservation, 200));
  encoder.Encode(2, 1, Bytes(kObservation, 7));
  const Bytes content = ContentOf(encoder.Encode(1, 2, Bytes(2 * kObservation, 10)));
  Bytes expected(kObservation, 66);  // environment 1: 10 - 200 + 256
  expected.resize(2 * kObservation, 3);
  EXPECT_EQ(content, expected);
}

TEST(ObservationEncoderTest, UnchangedObservationsTakeFewBytes) {
  ObservationEncoder encoder(64, kObservationBytes);
  const Bytes observations = Noise(1, 64 * kObservationBytes);
  encoder.Encode(0, 64, observations);
  EXPECT_LT(encoder.Encode(0, 64, observations).size(), 128);
}

TEST(ObservationEncoderTest, IncompressibleObservationsStayWithinTheBound) {
  for (const size_t size : {1, 256, 1000, 12288, 100000}) {
    for (const int32_t count : {1, 3, 16}) {
      ObservationEncoder encoder(count, size);
      const Bytes noise = Noise(3, static_cast<size_t>(count) * size);
      const int64_t bytes_max =
          count * EncodedBytesMax(Encoding::kDeltaZstd, static_cast<int64_t>(size));
      EXPECT_LE(encoder.Encode(0, count, noise).size(), bytes_max) << size << " times " << count;
      EXPECT_LE(ZSTD_compressBound(noise.size()), bytes_max) << size << " times " << count;
    }
  }
  EXPECT_EQ(EncodedBytesMax(Encoding::kRaw, 12288), 12288);
}

// Decodes into memory between guards: what the decoder returned and whether they are intact.
struct Decoded {
  absl::Status status;
  Bytes observations;
  bool guards_are_intact = false;
};

Decoded DecodeGuarded(const std::string& encoded, int32_t count = 2) {
  constexpr size_t kGuard = 4096;
  ObservationDecoder decoder(count, kObservation);
  const size_t size = static_cast<size_t>(count) * kObservation;
  Bytes memory(size + 2 * kGuard, 0xa5);
  Decoded decoded;
  decoded.status = decoder.Decode(0, count, encoded, absl::MakeSpan(memory).subspan(kGuard, size));
  const auto begin = memory.begin() + kGuard;
  const auto end = begin + static_cast<std::ptrdiff_t>(size);
  const auto is_guard = [](uint8_t byte) { return byte == 0xa5; };
  decoded.guards_are_intact =
      std::all_of(memory.begin(), begin, is_guard) && std::all_of(end, memory.end(), is_guard);
  decoded.observations.assign(begin, end);
  return decoded;
}

TEST(ObservationDecoderTest, FramesOfOtherEncodersAreDecoded) {
  const Bytes content = Noise(4, 2 * kObservation);
  const Decoded decoded = DecodeGuarded(FrameOf(content));
  EXPECT_THAT(decoded.status, IsOk());
  EXPECT_EQ(decoded.observations, content);
  EXPECT_TRUE(decoded.guards_are_intact);
}

TEST(ObservationDecoderTest, OtherBytesAreDataLossAndNothingBeyondIsWritten) {
  const std::string frame = FrameOf(Noise(4, 2 * kObservation));
  const std::string magic = "\x28\xb5\x2f\xfd";
  std::vector<std::pair<std::string, std::string>> cases = {
      {"too long", FrameOf(Noise(4, 2 * kObservation + 1))},
      {"much too long", FrameOf(Bytes(100000, 0))},
      {"too short", FrameOf(Noise(4, 2 * kObservation - 1))},
      {"two frames", frame + frame},
      {"bytes follow", frame + "x"},
      {"raw", std::string(2 * kObservation, 'o')},
      {"garbage", magic + std::string(40, '\xff')},
      {"claims 1 TiB", magic + std::string("\xe0\0\0\0\0\0\1\0\0\1", 10)},
      // One byte, repeated 128 Ki times.
      {"claims 128 KiB", magic + std::string("\xa0\0\0\2\0\3\0\x10\0", 9)},
  };
  for (size_t size = 0; size < frame.size(); ++size) {
    cases.emplace_back("cut off", frame.substr(0, size));
  }
  for (const auto& [name, encoded] : cases) {
    const Decoded decoded = DecodeGuarded(encoded);
    EXPECT_THAT(decoded.status, StatusIs(absl::StatusCode::kDataLoss,
                                         HasSubstr("observations of 2 environments cannot be")))
        << name;
    EXPECT_TRUE(decoded.guards_are_intact) << name;
  }
}

}  // namespace
}  // namespace procgen
