#include "server/rpc/step/response.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

std::string BytesOf(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  EXPECT_TRUE(buffer.Dump(&slices).ok());
  std::string bytes;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

Response ResponseOf(int rows) {
  Response response;
  response.message.set_sequence_number(300);
  v1::Batch* batch = response.message.mutable_batch();
  batch->set_env_count(rows);
  batch->set_last(true);
  for (int row = 0; row < rows; ++row) {
    batch->add_rewards(static_cast<float>(row));
    batch->add_first(row % 2 == 0);
    batch->add_level_seeds(row * 1000);
  }
  return response;
}

Request StepOf(int32_t env_count) {
  Request request;
  request.sequence_number = 7;
  request.kind = Request::Kind::kStep;
  request.count = env_count;
  return request;
}

TEST(ResponseTest, BytesAreThoseOfTheWholeMessage) {
  // Sizes at which the varint lengths of batch and field grow by a byte.
  for (const size_t size : {1U, 90U, 127U, 128U, 16383U, 16384U, 3000000U}) {
    for (const int rows : {1, 341}) {
      Response response = ResponseOf(rows);
      const std::string pictures(size, 'p');
      response.observations = grpc::Slice(pictures);
      v1::StepPoolResponse whole = response.message;
      whole.mutable_batch()->set_observations(pictures);
      EXPECT_EQ(BytesOf(Serialized(response)), whole.SerializeAsString())
          << size << " bytes, " << rows << " rows";
    }
  }
}

TEST(ResponseTest, WithoutObservationsTheMessageIsTheWholeResponse) {
  const Response response = ResponseOf(3);
  EXPECT_EQ(BytesOf(Serialized(response)), response.message.SerializeAsString());
}

TEST(ResponseTest, ObservationsAreNotCopied) {
  Response response = ResponseOf(3);
  response.observations = grpc::Slice(std::string(100000, 'p'));
  std::vector<grpc::Slice> slices;
  ASSERT_TRUE(Serialized(response).Dump(&slices).ok());
  ASSERT_EQ(slices.size(), 2U);
  EXPECT_EQ(slices[1].begin(), response.observations.begin());
}

TEST(ResponseTest, OnlyFinalObservationsOfEndsAreKept) {
  Request request = StepOf(4);
  request.with_final_observations = true;
  FrameBufferPool frames;
  Response response;
  const Batch batch = PrepareResponse(request, {0, 4}, kObservationBytes, &frames, &response);
  for (size_t row = 0; row < 4; ++row) {
    std::fill_n(batch.final_observations.begin() + static_cast<ptrdiff_t>(row * kObservationBytes),
                kObservationBytes, static_cast<uint8_t>(row));
  }
  batch.terminated[1] = 1;
  batch.truncated[3] = 1;
  CompleteResponse(kObservationBytes, batch, &response.message);
  const std::string& kept = response.message.batch().final_observations();
  ASSERT_EQ(kept.size(), 2U * kObservationBytes);
  EXPECT_EQ(kept.front(), 1);
  EXPECT_EQ(kept.back(), 3);
}

TEST(ResponseTest, OnlyFingerprintsOfEndsAreKept) {
  const Request request = StepOf(5);
  FrameBufferPool frames;
  Response response;
  const Batch batch = PrepareResponse(request, {0, 5}, kObservationBytes, &frames, &response);
  ASSERT_EQ(batch.fingerprints.size(), 5U);
  for (size_t row = 0; row < 5; ++row) {
    batch.fingerprints[row] = UINT64_MAX - row;
  }
  batch.terminated[1] = 1;
  batch.truncated[2] = 1;
  batch.terminated[4] = 1;
  CompleteResponse(kObservationBytes, batch, &response.message);
  EXPECT_THAT(response.message.batch().fingerprints(), testing::ElementsAre(-2, -3, -5));
}

TEST(ResponseTest, ResponseMemoryIsReused) {
  const Request request = StepOf(8);
  FrameBufferPool frames;
  Response response;
  const uint8_t* const before =
      PrepareResponse(request, {0, 8}, kObservationBytes, &frames, &response).observations.data();
  EXPECT_EQ(
      PrepareResponse(request, {0, 8}, kObservationBytes, &frames, &response).observations.data(),
      before);
  EXPECT_EQ(
      PrepareResponse(request, {0, 3}, kObservationBytes, &frames, &response).observations.data(),
      before);
}

}  // namespace
}  // namespace procgen
