// Decoded delta observations equal those of a raw pool.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/random/random_stream.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/observation_decoder.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::ElementsAre;

constexpr int32_t kEnvCount = 5;

v1::PoolSpec SpecOf(const std::string& game, v1::Encoding encoding,
                    const v1::ObservationFormat& format = {}) {
  v1::PoolSpec spec = MazeSpec(kEnvCount);
  spec.set_games(0, game);
  spec.set_encoding(encoding);
  *spec.mutable_observation_format() = format;
  return spec;
}

// A random slice of the pool.
v1::Slice AnySlice(RandomStream& random) {
  v1::Slice slice;
  slice.set_first_env(random.Int(kEnvCount));
  slice.set_env_count(1 + random.Int(kEnvCount - slice.first_env()));
  return slice;
}

// A random request for a slice: a step (repeated, with resets), a reset or an observe. One in four
// requests no observations.
v1::RunPoolRequest AnyRequest(RandomStream& random) {
  const v1::Slice slice = AnySlice(random);
  const bool unseen = random.Int(4) == 0;
  const v1::Observation observation = unseen ? v1::OBSERVATION_NONE : v1::OBSERVATION_FRAME;
  const int32_t kind = random.Int(8);
  v1::RunPoolRequest request;
  if (kind == 0) {
    *request.mutable_observe()->mutable_slice() = slice;
    request.mutable_observe()->set_observation(observation);
    return request;
  }
  if (kind == 1) {
    *request.mutable_reset()->mutable_slice() = slice;
    request.mutable_reset()->set_observation(observation);
    request.mutable_reset()->add_resets()->set_environment(slice.first_env());
    return request;
  }
  v1::Step* step = request.mutable_step();
  *step->mutable_slice() = slice;
  step->set_observation(observation);
  step->set_with_final_observations(kind % 2 == 0);
  step->set_repeat_count(1 + random.Int(3));
  for (int32_t i = 0; i < slice.env_count(); ++i) {
    step->add_actions(random.Int(20) == 0 ? -1 : random.Int(15));
  }
  if (kind == 2) {
    step->add_resets()->set_environment(slice.first_env());
  }
  return request;
}

// A pool with encoded observations and one with raw ones.
class EncodedPool {
 public:
  EncodedPool(std::unique_ptr<PoolStream> raw, std::unique_ptr<PoolStream> encoded)
      : raw_(std::move(raw)),
        encoded_(std::move(encoded)),
        observation_bytes_(static_cast<size_t>(encoded_->pool().observation_bytes())),
        decoder_(encoded_->pool().spec().env_count(), observation_bytes_) {}

  PoolStream& raw() { return *raw_; }
  PoolStream& encoded() { return *encoded_; }

  // Expects equal batches for `request`, after decoding.
  void ExpectSame(const v1::RunPoolRequest& request) {
    v1::Batch expected;
    v1::Batch batch;
    ASSERT_THAT(raw_->Call(request, &expected), IsOk());
    ASSERT_THAT(encoded_->Call(request, &batch), IsOk());
    if (!batch.observations().empty()) {
      std::string decoded(static_cast<size_t>(batch.env_count()) * observation_bytes_, '\0');
      ASSERT_THAT(decoder_.Decode(
                      batch.first_env(), batch.env_count(), batch.observations(),
                      absl::MakeSpan(reinterpret_cast<uint8_t*>(decoded.data()), decoded.size())),
                  IsOk());
      batch.set_observations(decoded);
    }
    ASSERT_TRUE(EqualMessages(batch, expected));
  }
  void ExpectSame(int request_count, int64_t seed) {
    RandomStream random(seed);
    for (int i = 0; i < request_count; ++i) {
      ASSERT_NO_FATAL_FAILURE(ExpectSame(AnyRequest(random))) << i;
    }
  }

 private:
  const std::unique_ptr<PoolStream> raw_;
  const std::unique_ptr<PoolStream> encoded_;
  const size_t observation_bytes_;
  procgen_client::ObservationDecoder decoder_;
};

class EncodingsTest : public ServiceTest {
 protected:
  EncodedPool Pools(const std::string& game, const v1::ObservationFormat& format = {}) {
    return {StartPool(SpecOf(game, v1::ENCODING_RAW, format)),
            StartPool(SpecOf(game, v1::ENCODING_DELTA_ZSTD, format))};
  }
};

class EncodedFormatsTest : public EncodingsTest,
                           public testing::WithParamInterface<std::tuple<std::string, int>> {
 protected:
  // 0: RGB; 1: a stack of grayscale frames; 2: planar frames of odd size.
  static v1::ObservationFormat FormatOf(int number) {
    v1::ObservationFormat format;
    if (number == 1) {
      format.set_color(v1::COLOR_GRAYSCALE);
      format.set_size_px(84);
      format.set_frame_stack(4);
    } else if (number == 2) {
      format.set_layout(v1::LAYOUT_CHW);
      format.set_size_px(43);
    }
    return format;
  }
};

TEST_P(EncodedFormatsTest, DecodedBatchesEqualARawPool) {
  const auto& [game, format] = GetParam();
  EncodedPool pools = Pools(game, FormatOf(format));
  EXPECT_EQ(pools.encoded().pool().spec().encoding(), v1::ENCODING_DELTA_ZSTD);
  EXPECT_EQ(pools.encoded().pool().observation_bytes(), pools.raw().pool().observation_bytes());
  pools.ExpectSame(/*request_count=*/300, /*seed=*/format);
}

constexpr const char* kFormatNames[] = {"Coloured", "GreyStack", "OddPlanes"};

INSTANTIATE_TEST_SUITE_P(All, EncodedFormatsTest,
                         testing::Combine(testing::Values("coinrun", "fruitbot", "maze"),
                                          testing::Range(0, 3)),
                         [](const auto& info) {
                           return absl::StrCat(std::get<0>(info.param),
                                               kFormatNames[std::get<1>(info.param)]);
                         });

TEST_F(EncodingsTest, RestoredStatesAreEncoded) {
  EncodedPool pools = Pools("coinrun");
  pools.ExpectSame(/*request_count=*/10, /*seed=*/1);
  const auto states = pools.encoded().Save();
  ASSERT_THAT(states, IsOk());
  pools.ExpectSame(/*request_count=*/10, /*seed=*/2);
  for (PoolStream* run : {&pools.raw(), &pools.encoded()}) {
    ASSERT_THAT(run->Restore(*states), IsOk());
    ASSERT_THAT(run->Clone({Pair(0, 4)}), IsOk());
  }
  pools.ExpectSame(ObserveRequest(kEnvCount));
  pools.ExpectSame(/*request_count=*/10, /*seed=*/3);
}

TEST_F(EncodingsTest, CountedBytesEqualWireBytes) {
  const auto sent_by = [&](v1::Encoding encoding) {
    const auto stream = StartPool(SpecOf("maze", encoding));
    const int64_t before = client_->GetLoad()->stream_sent_bytes();
    v1::Batch batch;
    for (int i = 0; i < 50; ++i) {
      EXPECT_THAT(stream->Step(std::vector<int32_t>(kEnvCount, 7), &batch), IsOk());
    }
    return client_->GetLoad()->stream_sent_bytes() - before;
  };
  const int64_t raw = sent_by(v1::ENCODING_RAW);
  EXPECT_GT(raw, 50 * kEnvCount * 12288);
  EXPECT_LT(sent_by(v1::ENCODING_DELTA_ZSTD), raw / 16);
}

TEST_F(EncodingsTest, CatalogListsEncodings) {
  const auto catalog = client_->GetCatalog();
  ASSERT_THAT(catalog, IsOk());
  EXPECT_THAT(catalog->encodings(), ElementsAre(v1::ENCODING_RAW, v1::ENCODING_DELTA_ZSTD));
}

TEST_F(EncodingsTest, UnsupportedEncodingsAreRejected) {
  // 3 was LZ4.
  for (const int number : {3, 7}) {
    EXPECT_THAT(StartError(SpecOf("maze", static_cast<v1::Encoding>(number))),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         absl::StrCat("spec.encoding is number ", number,
                                      ", allowed: ENCODING_RAW, ENCODING_DELTA_ZSTD")));
  }
}

}  // namespace
}  // namespace procgen
