// Decoded delta observations equal those of a raw pool.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "envcore/random/random_stream.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen_client/observation_decoder.h"
#include "tests/service/robustness/damaging_server.h"
#include "tests/service/service_fixture.h"
#include "tests/service/stream/batch_copy.h"
#include "tests/service/stream/raw_stream.h"

namespace procgen {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

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
v1::StepPoolRequest AnyRequest(RandomStream& random) {
  const v1::Slice slice = AnySlice(random);
  const bool unseen = random.Int(4) == 0;
  const v1::Observation observation = unseen ? v1::OBSERVATION_NONE : v1::OBSERVATION_FRAME;
  const int32_t kind = random.Int(8);
  v1::StepPoolRequest request;
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

class EncodingsTest : public ServiceTest {
 protected:
  // Expects equal batches for `request`.
  static void ExpectSameAnswer(procgen_client::StepStream& raw, procgen_client::StepStream& encoded,
                               const v1::StepPoolRequest& request) {
    procgen_client::Batch expected;
    procgen_client::Batch batch;
    ASSERT_THAT(raw.Call(request, &expected), IsOk());
    ASSERT_THAT(encoded.Call(request, &batch), IsOk());
    ASSERT_EQ(batch.first_env(), expected.first_env());
    ASSERT_TRUE(BatchCopy(batch) == BatchCopy(expected));
  }
  static void ExpectSameAnswers(procgen_client::StepStream& raw,
                                procgen_client::StepStream& encoded, int request_count,
                                int64_t seed) {
    RandomStream random(seed);
    for (int i = 0; i < request_count; ++i) {
      ASSERT_NO_FATAL_FAILURE(ExpectSameAnswer(raw, encoded, AnyRequest(random))) << i;
    }
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
  // Room for two to four observations, so most batches take several responses.
  const procgen_client::StreamOptions options = {.response_bytes_max = 65536};
  const auto raw = CreateAndAttach(SpecOf(game, v1::ENCODING_RAW, FormatOf(format)), options);
  const auto encoded =
      CreateAndAttach(SpecOf(game, v1::ENCODING_DELTA_ZSTD, FormatOf(format)), options);
  EXPECT_EQ(encoded->pool().spec().encoding(), v1::ENCODING_DELTA_ZSTD);
  EXPECT_EQ(encoded->pool().observation_bytes(), raw->pool().observation_bytes());
  ExpectSameAnswers(*raw, *encoded, /*request_count=*/300, /*seed=*/format);
}

constexpr const char* kFormatNames[] = {"Coloured", "GreyStack", "OddPlanes"};

INSTANTIATE_TEST_SUITE_P(All, EncodedFormatsTest,
                         testing::Combine(testing::Values("coinrun", "fruitbot", "maze"),
                                          testing::Range(0, 3)),
                         [](const auto& info) {
                           return absl::StrCat(std::get<0>(info.param),
                                               kFormatNames[std::get<1>(info.param)]);
                         });

class EncodingTest : public EncodingsTest {
 protected:
  void SetUp() override {
    EncodingsTest::SetUp();
    stub_ = v1::StepService::NewStub(channel_);
  }

  std::unique_ptr<RawStream> Open(const std::string& pool, bool resumable) {
    v1::Attach attach;
    attach.set_pool(pool);
    attach.set_resumable(resumable);
    attach.set_take_over(true);
    return std::make_unique<RawStream>(stub_.get(), attach);
  }

  // The decoded observations of a response.
  static absl::StatusOr<std::vector<uint8_t>> Decode(procgen_client::ObservationDecoder& decoder,
                                                     const v1::StepPoolResponse& response) {
    const v1::Batch& batch = response.batch();
    std::vector<uint8_t> observations(static_cast<size_t>(batch.env_count()) *
                                      decoder.observation_bytes());
    absl::Status status = decoder.Decode(batch.first_env(), batch.env_count(), batch.observations(),
                                         absl::MakeSpan(observations));
    if (!status.ok()) {
      return status;
    }
    return observations;
  }

  // The observations of a raw pool after each of `steps` steps with action 7.
  std::vector<std::vector<uint8_t>> Expected(const std::string& game, int steps) {
    const auto raw = CreateAndAttach(SpecOf(game, v1::ENCODING_RAW));
    std::vector<std::vector<uint8_t>> observations;
    procgen_client::Batch batch;
    for (int i = 0; i < steps; ++i) {
      EXPECT_THAT(raw->Step(right_, &batch), IsOk());
      observations.push_back(BatchCopy(batch).observations);
    }
    return observations;
  }

  const std::vector<int32_t> right_ = std::vector<int32_t>(kEnvCount, 7);
  std::unique_ptr<v1::StepService::Stub> stub_;
};

TEST_F(EncodingTest, RepeatedResponsesKeepTheirDeltasAndOthersStartFromKeyFrames) {
  const std::vector<std::vector<uint8_t>> expected = Expected("coinrun", 4);
  const std::string pool = CreatePool(SpecOf("coinrun", v1::ENCODING_DELTA_ZSTD));
  auto decoder = procgen_client::ObservationDecoder::Make(*client_->GetPool(pool));
  auto newcomer = procgen_client::ObservationDecoder::Make(*client_->GetPool(pool));
  ASSERT_THAT(decoder, IsOk());
  ASSERT_THAT(newcomer, IsOk());

  const auto first = Open(pool, /*resumable=*/true);
  first->Receive();
  first->Send(StepRequest(right_), 1);
  EXPECT_EQ(*Decode(*decoder, first->Receive()), expected[0]);
  first->Send(StepRequest(right_), 2);
  const v1::StepPoolResponse unread = first->Receive();
  first->Break();

  const auto second = Open(pool, /*resumable=*/true);
  second->Receive();
  second->Send(StepRequest(right_), 2);
  const v1::StepPoolResponse again = second->Receive();
  EXPECT_EQ(again.SerializeAsString(), unread.SerializeAsString());
  EXPECT_THAT(Decode(*newcomer, again),
              StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("are missing")));
  EXPECT_EQ(*Decode(*decoder, again), expected[1]);
  for (const int64_t number : {3, 4}) {
    second->Send(StepRequest(right_), number);
    const v1::StepPoolResponse answer = second->Receive();
    EXPECT_EQ(*Decode(*decoder, answer), expected[static_cast<size_t>(number - 1)]);
    EXPECT_EQ(*Decode(*newcomer, answer), expected[static_cast<size_t>(number - 1)]);
  }
}

TEST_F(EncodingTest, UnreadResponsesAreNoDeltaBase) {
  const std::vector<std::vector<uint8_t>> expected = Expected("coinrun", 5);
  const std::string pool = CreatePool(SpecOf("coinrun", v1::ENCODING_DELTA_ZSTD));
  const auto first = Open(pool, /*resumable=*/false);
  first->Receive();
  first->Send(StepRequest(right_), 1);
  first->Receive();
  first->Send(StepRequest(right_), 2);
  first->Send(StepRequest(right_), 3);
  first->Break();

  const auto stream = client_->Attach(pool, {.take_over = true});
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  for (int i = 0; i < 2; ++i) {
    ASSERT_THAT((*stream)->Step(right_, &batch), IsOk());
    EXPECT_EQ(BatchCopy(batch).observations,
              expected[static_cast<size_t>(batch.sequence_number() - 1)]);
  }
}

TEST_F(EncodingTest, TakeoverEqualsARawPool) {
  const auto raw = CreateAndAttach(SpecOf("fruitbot", v1::ENCODING_RAW));
  const std::string pool = CreatePool(SpecOf("fruitbot", v1::ENCODING_DELTA_ZSTD));
  const auto first = client_->Attach(pool);
  ASSERT_THAT(first, IsOk());
  ExpectSameAnswers(*raw, **first, /*request_count=*/20, /*seed=*/1);
  const auto other_client = Connect();
  const auto second = other_client->Attach(pool, {.take_over = true});
  ASSERT_THAT(second, IsOk());
  ExpectSameAnswers(*raw, **second, /*request_count=*/20, /*seed=*/2);
  EXPECT_THAT(CallStatus(first->get(), StepRequest(right_)),
              StatusIs(absl::StatusCode::kAborted, HasSubstr("took over")));
}

TEST_F(EncodingTest, RestoredStatesAreEncoded) {
  const auto raw = CreateAndAttach(SpecOf("coinrun", v1::ENCODING_RAW));
  const auto encoded = CreateAndAttach(SpecOf("coinrun", v1::ENCODING_DELTA_ZSTD));
  ExpectSameAnswers(*raw, *encoded, /*request_count=*/10, /*seed=*/1);
  const auto states = client_->SaveStates(encoded->pool().name());
  ASSERT_THAT(states, IsOk());
  ExpectSameAnswers(*raw, *encoded, /*request_count=*/10, /*seed=*/2);
  for (const procgen_client::StepStream* stream : {raw.get(), encoded.get()}) {
    ASSERT_THAT(client_->RestoreStates(stream->pool().name(), *states), IsOk());
    ASSERT_THAT(client_->CloneStates(stream->pool().name(), {Pair(0, 4)}), IsOk());
  }
  v1::StepPoolRequest observe;
  observe.mutable_observe();
  ExpectSameAnswer(*raw, *encoded, observe);
  ExpectSameAnswers(*raw, *encoded, /*request_count=*/10, /*seed=*/3);
}

TEST_F(EncodingTest, CountedBytesEqualWireBytes) {
  const auto sent_by = [&](v1::Encoding encoding) {
    const auto stream = CreateAndAttach(SpecOf("maze", encoding));
    const int64_t before = client_->GetLoad()->stream_sent_bytes();
    procgen_client::Batch batch;
    for (int i = 0; i < 50; ++i) {
      EXPECT_THAT(stream->Step(right_, &batch), IsOk());
    }
    return client_->GetLoad()->stream_sent_bytes() - before;
  };
  const int64_t raw = sent_by(v1::ENCODING_RAW);
  EXPECT_GT(raw, 50 * kEnvCount * 12288);
  EXPECT_LT(sent_by(v1::ENCODING_DELTA_ZSTD), raw / 16);
}

TEST_F(EncodingTest, DamagedResponsesEndTheStream) {
  const std::string pool = CreatePool(SpecOf("coinrun", v1::ENCODING_DELTA_ZSTD));
  const auto bytes_of = [](v1::StepPoolResponse* response) {
    return response->mutable_batch()->mutable_observations();
  };
  const std::pair<DamagingServer::Damage, std::string> cases[] = {
      {[&](auto* response) { (*bytes_of(response))[bytes_of(response)->size() / 2] ^= 1; },
       "request 3: encoded observations: "},
      {[&](auto* response) { bytes_of(response)->resize(bytes_of(response)->size() / 2); },
       "request 6: encoded observations: "},
      {[&](auto* response) { bytes_of(response)->assign(20 << 20, 'x'); },
       "request 9: encoded observations: "},
      {[](auto* response) { response->mutable_batch()->set_env_count(1 << 30); },
       "request 12: 1073741824 environments from 0, expected: 1 to 5 from 0"},
      {[](auto* response) { response->mutable_batch()->set_first_env(1); },
       "request 15: 5 environments from 1, expected: 1 to 5 from 0"},
  };
  int64_t number = 0;
  for (const auto& [damage, message] : cases) {
    number += 3;
    DamagingServer between(channel_, number, damage);
    const auto client =
        procgen_client::Client::Connect(between.address(), {.response_bytes_max = 64 << 20});
    ASSERT_THAT(client, IsOk());
    const auto stream = (*client)->Attach(pool, {.take_over = true});
    ASSERT_THAT(stream, IsOk());
    procgen_client::Batch batch;
    ASSERT_THAT((*stream)->Step(right_, &batch), IsOk());
    ASSERT_THAT((*stream)->Step(right_, &batch), IsOk());
    EXPECT_THAT((*stream)->Step(right_, &batch),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(message)));
    EXPECT_THAT((*stream)->Observe(&batch),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(message)));
  }
}

TEST_F(EncodingTest, DuplicateResponsesAreDetected) {
  const std::string pool = CreatePool(SpecOf("coinrun", v1::ENCODING_DELTA_ZSTD));
  std::string second;
  DamagingServer between(channel_, 3, [&](v1::StepPoolResponse* response) {
    response->mutable_batch()->set_observations(second);
  });
  // The responses of an equal pool to another learner.
  const auto stream =
      Open(CreatePool(SpecOf("coinrun", v1::ENCODING_DELTA_ZSTD)), /*resumable=*/false);
  stream->Receive();
  for (const int64_t number : {1, 2}) {
    stream->Send(StepRequest(right_), number);
    second = stream->Receive().batch().observations();
  }
  const auto client = procgen_client::Client::Connect(between.address());
  ASSERT_THAT(client, IsOk());
  const auto learner = (*client)->Attach(pool);
  ASSERT_THAT(learner, IsOk());
  procgen_client::Batch batch;
  ASSERT_THAT((*learner)->Step(right_, &batch), IsOk());
  ASSERT_THAT((*learner)->Step(right_, &batch), IsOk());
  EXPECT_THAT((*learner)->Step(right_, &batch),
              StatusIs(absl::StatusCode::kDataLoss,
                       AllOf(HasSubstr("request 3"), HasSubstr("came twice"))));
}

TEST_F(EncodingTest, UnknownEncodingsAreRejected) {
  const std::string pool = CreatePool(SpecOf("coinrun", v1::ENCODING_DELTA_ZSTD));
  DamagingServer between(channel_, 0, [&](v1::StepPoolResponse* response) {
    v1::PoolSpec* spec = response->mutable_attached()->mutable_pool()->mutable_spec();
    spec->set_encoding(static_cast<v1::Encoding>(9));
  });
  const auto client = procgen_client::Client::Connect(between.address());
  ASSERT_THAT(client, IsOk());
  EXPECT_THAT((*client)->Attach(pool),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("encoding is 9")));
  EXPECT_THAT(client_->Attach(pool, {.take_over = true}), IsOk());
}

TEST_F(EncodingsTest, CatalogListsEncodings) {
  const auto catalog = client_->GetCatalog();
  ASSERT_THAT(catalog, IsOk());
  EXPECT_THAT(catalog->encodings(), ElementsAre(v1::ENCODING_RAW, v1::ENCODING_DELTA_ZSTD));
}

TEST_F(EncodingsTest, UnsupportedEncodingsAreRejected) {
  // 3 was LZ4.
  for (const int number : {3, 7}) {
    EXPECT_THAT(client_->CreatePool(SpecOf("maze", static_cast<v1::Encoding>(number))),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         absl::StrCat("spec.encoding is number ", number,
                                      ", allowed: ENCODING_RAW, ENCODING_DELTA_ZSTD")));
  }
  v1::PoolSpec shared = SpecOf("maze", v1::ENCODING_DELTA_ZSTD);
  shared.set_transport(v1::TRANSPORT_SHARED_MEMORY);
  EXPECT_THAT(client_->CreatePool(shared),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("allowed with TRANSPORT_SHARED_MEMORY: ENCODING_RAW")));
}

}  // namespace
}  // namespace procgen
