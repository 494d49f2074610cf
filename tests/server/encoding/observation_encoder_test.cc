#include "server/encoding/observation_encoder.h"

#include <cstdint>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "envcore/random/random_stream.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/observation_decoder.h"
#include "tests/server/encoding/encoded_play.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using procgen_client::ObservationDecoder;
using testing::HasSubstr;
using Picture = std::vector<uint8_t>;

constexpr PictureShape kShape = {.rows = 64, .columns = 64, .pixel_bytes = 3};

ObservationEncoder NewEncoder(int32_t env_count = 1) { return {kShape, env_count}; }

ObservationDecoder NewDecoder(int32_t env_count = 1) {
  procgen::v1::Pool pool;
  pool.mutable_spec()->set_env_count(env_count);
  pool.mutable_spec()->set_encoding(procgen::v1::ENCODING_DELTA_ZSTD);
  return ObservationDecoder::Make(pool).value();
}

// `count` frames of random bytes.
Picture Noise(int64_t seed, size_t count = 1) {
  RandomStream random(seed);
  Picture picture(kShape.bytes() * count);
  for (uint8_t& byte : picture) {
    byte = static_cast<uint8_t>(random.Int(256));
  }
  return picture;
}

// A frame that shows a part of `world`, shifted by `rows` down and `columns` right.
Picture ViewOf(const Picture& world, int32_t rows, int32_t columns) {
  constexpr int32_t kWorldColumns = 128;
  Picture view;
  for (int32_t row = 0; row < kShape.rows; ++row) {
    const auto begin = world.begin() + ((row + rows) * kWorldColumns + columns) * 3;
    view.insert(view.end(), begin, begin + kShape.columns * 3);
  }
  return view;
}

std::string Encode(ObservationEncoder& encoder, const Picture& picture, int32_t first = 0) {
  return encoder.Encode(first, static_cast<int32_t>(picture.size() / kShape.bytes()), picture);
}

absl::StatusOr<Picture> Decode(ObservationDecoder& decoder, const std::string& encoded,
                               int32_t first = 0, int32_t count = 1) {
  Picture picture(kShape.bytes() * static_cast<size_t>(count));
  absl::Status status = decoder.Decode(first, count, encoded, absl::MakeSpan(picture));
  if (!status.ok()) {
    return status;
  }
  return picture;
}

MATCHER_P(Shows, picture, "is OK and shows the picture") {
  *result_listener << "whose status is " << arg.status();
  return arg.ok() && *arg == picture;
}

TEST(ObservationEncoderTest, UnchangedObservationsTakeFewBytes) {
  ObservationEncoder encoder = NewEncoder(64);
  const Picture pictures = Noise(1, 64);
  Encode(encoder, pictures);
  EXPECT_LT(Encode(encoder, pictures).size(), 64);
}

TEST(ObservationEncoderTest, MovedViewIsEncodedAsMotionAndNewEdge) {
  const Picture world = Noise(2, 4);
  ObservationEncoder encoder = NewEncoder();
  ObservationDecoder decoder = NewDecoder();
  ASSERT_THAT(Decode(decoder, Encode(encoder, ViewOf(world, 8, 8))), IsOk());
  for (const auto& [rows, columns] : {std::pair(8, 11), {10, 11}, {5, 7}, {5, 8}}) {
    const Picture view = ViewOf(world, rows, columns);
    const std::string encoded = Encode(encoder, view);
    // Noise is incompressible, so this bounds the new pixels: at most four rows and four columns.
    EXPECT_LT(encoded.size(), 8 * kShape.row_bytes() + 512) << rows << ", " << columns;
    const auto decoded = Decode(decoder, encoded);
    ASSERT_THAT(decoded, IsOk());
    EXPECT_EQ(*decoded, view);
  }
}

TEST(ObservationEncoderTest, IncompressibleObservationsStayWithinTheBound) {
  ObservationEncoder encoder = NewEncoder(3);
  ObservationDecoder decoder = NewDecoder(3);
  for (int64_t seed = 0; seed < 4; ++seed) {
    const Picture noise = Noise(seed, 3);
    const std::string encoded = Encode(encoder, noise);
    EXPECT_LE(encoded.size(), 3 * ObservationEncoder::EncodedBytesMax(kShape));
    const auto decoded = Decode(decoder, encoded, 0, 3);
    ASSERT_THAT(decoded, IsOk());
    EXPECT_EQ(*decoded, noise);
  }
}

TEST(ObservationEncoderTest, BatchTakesAtMostTheSumOfItsObservations) {
  for (const PictureShape& shape : {PictureShape{.rows = 16, .columns = 16, .pixel_bytes = 1},
                                    kShape, PictureShape{512 * 3 * 16, 512, 1, 16}}) {
    const size_t content = shape.bytes() + static_cast<size_t>(shape.block_count());
    const size_t one = Compressor::FrameBytesMax(content);
    for (const size_t count : {2, 3, 10, 341, 4096}) {
      EXPECT_LE(Compressor::FrameBytesMax(count * content), count * one) << count;
    }
  }
}

TEST(ObservationEncoderTest, UsedDecoderReadsANewEncoder) {
  ObservationEncoder encoder = NewEncoder(2);
  ObservationDecoder decoder = NewDecoder(2);
  ASSERT_THAT(Decode(decoder, Encode(encoder, Noise(1, 2)), 0, 2), IsOk());
  ASSERT_THAT(Decode(decoder, Encode(encoder, Noise(2, 2)), 0, 2), IsOk());
  ObservationEncoder other = NewEncoder(2);
  EXPECT_THAT(Decode(decoder, Encode(other, Noise(3, 1), 1), 1), Shows(Noise(3, 1)));
  EXPECT_THAT(Decode(decoder, Encode(other, Noise(4, 2)), 0, 2), Shows(Noise(4, 2)));
}

TEST(ObservationEncoderTest, MissingOrDuplicateResponsesAreDetected) {
  ObservationEncoder encoder = NewEncoder();
  ObservationDecoder decoder = NewDecoder();
  const std::string first = Encode(encoder, Noise(1));
  const std::string second = Encode(encoder, Noise(2));
  const std::string third = Encode(encoder, Noise(3));
  EXPECT_THAT(Decode(decoder, second),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("came twice")));
  ASSERT_THAT(Decode(decoder, first), IsOk());
  EXPECT_THAT(Decode(decoder, third),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("came twice")));
  ASSERT_THAT(Decode(decoder, second), Shows(Noise(2)));
  EXPECT_THAT(Decode(decoder, second),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("came twice")));
  EXPECT_THAT(Decode(decoder, third), Shows(Noise(3)));
}

TEST(ObservationEncoderTest, AgesWrapWithoutAKeyFrame) {
  ObservationEncoder encoder = NewEncoder();
  ObservationDecoder decoder = NewDecoder();
  Picture picture = Noise(1);
  for (int i = 0; i < 600; ++i) {
    picture[static_cast<size_t>(i) * 20] ^= 1;
    const std::string encoded = Encode(encoder, picture);
    ASSERT_THAT(Decode(decoder, encoded), Shows(picture)) << i;
    if (i > 0) {
      ASSERT_LT(encoded.size(), 100) << i;
    }
  }
}

TEST(ObservationEncoderTest, DamagedBytesAreRejectedOrChangeNothing) {
  EncodedPlay play({.game = "coinrun", .env_count = 2});
  ObservationDecoder decoder = ObservationDecoder::Make(play.pool()).value();
  for (int step = 0; step < 12; ++step) {
    const EncodedAnswer answer = play.Next();
    for (size_t i = 0; i < answer.encoded.size(); i += 1 + answer.encoded.size() / 300) {
      std::string flipped = answer.encoded;
      flipped[i] = static_cast<char>(flipped[i] ^ (1 << (i % 8)));
      ObservationDecoder copy = decoder;
      const auto decoded = Decode(copy, flipped, answer.first, answer.count);
      // Some header bits have no effect.
      EXPECT_TRUE(!decoded.ok() || *decoded == answer.observations) << "byte " << i;
      const std::string cut = answer.encoded.substr(0, i);
      EXPECT_THAT(Decode(decoder, cut, answer.first, answer.count),
                  StatusIs(absl::StatusCode::kDataLoss, HasSubstr("encoded observations")))
          << "cut at " << i;
    }
    EXPECT_THAT(Decode(decoder, answer.encoded + "x", answer.first, answer.count),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr("encoded observations")));
    // Rejected responses have not changed the decoder.
    ASSERT_THAT(Decode(decoder, answer.encoded, answer.first, answer.count),
                Shows(answer.observations));
  }
}

TEST(ObservationEncoderTest, EnvironmentsOutOfRangeAreRejected) {
  ObservationEncoder encoder = NewEncoder(2);
  ObservationDecoder decoder = NewDecoder(2);
  const std::string encoded = Encode(encoder, Noise(1, 2));
  EXPECT_THAT(Decode(decoder, encoded, 1, 2),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("the pool has 2")));
  EXPECT_THAT(Decode(decoder, encoded, -1, 2),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("the pool has 2")));
  EXPECT_THAT(Decode(decoder, encoded, 0, 0),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("the pool has 2")));
  Picture small(7);
  EXPECT_THAT(decoder.Decode(0, 2, encoded, absl::MakeSpan(small)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("observations has 7 bytes")));
}

TEST(ObservationDecoderTest, OtherEncodingsAreRejected) {
  procgen::v1::Pool pool;
  pool.mutable_spec()->set_env_count(1);
  pool.mutable_spec()->set_encoding(procgen::v1::ENCODING_RAW);
  EXPECT_THAT(ObservationDecoder::Make(pool),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("encoding is 1")));
}

}  // namespace
}  // namespace procgen
