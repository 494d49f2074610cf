#include "server/rpc/response.h"

#include <string>
#include <vector>

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
  batch->set_environment_count(rows);
  batch->set_last(true);
  for (int row = 0; row < rows; ++row) {
    batch->add_rewards(static_cast<float>(row));
    batch->add_first(row % 2 == 0);
    batch->add_level_seeds(row * 1000);
  }
  return response;
}

TEST(ResponseTest, BytesAreThoseOfTheWholeMessage) {
  // Sizes at which lengths take another byte, of the batch and of the field.
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

TEST(ResponseTest, WithoutObservationsTheMessageIsAll) {
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

}  // namespace
}  // namespace procgen
