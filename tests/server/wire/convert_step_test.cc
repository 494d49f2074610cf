#include "server/wire/convert_step.h"

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/rpc/step/frame_buffer_pool.h"
#include "server/rpc/step/response.h"
#include "server/session/quota/limits.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::HasSubstr;

StreamRequest WholeStep(int32_t env_count) {
  StreamRequest request;
  request.message.set_sequence_number(7);
  request.message.mutable_step()->mutable_actions()->Resize(env_count, 4);
  EXPECT_THAT(ReadStreamRequest(&request), IsOk());
  request.request.count = env_count;
  return request;
}

// The coding of frames of `size_px` pixels.
ObservationCoding CodingOf(int32_t size_px, Encoding encoding = Encoding::kRaw) {
  ObservationFormat format;
  format.frame.size_px = size_px;
  return ObservationCoding(format, encoding);
}

TEST(ConvertStepTest, EmptyRequestIsRejected) {
  StreamRequest request;
  EXPECT_THAT(ReadStreamRequest(&request),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("is empty, allowed")));
}

TEST(ConvertStepTest, SecondAttachIsRejected) {
  StreamRequest request;
  request.message.mutable_attach();
  EXPECT_THAT(ReadStreamRequest(&request),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("attach was sent again")));
}

TEST(ConvertStepTest, UnknownObservationIsRejected) {
  StreamRequest request;
  request.message.mutable_observe()->set_observation(static_cast<v1::Observation>(9));
  EXPECT_THAT(ReadStreamRequest(&request),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("observation is number 9")));
}

TEST(ConvertStepTest, ChunkCountsOutOfRangeAreRejected) {
  for (const int32_t count : {-1, 65}) {
    StreamRequest request;
    request.message.mutable_step()->set_chunk_count(count);
    EXPECT_THAT(ReadStreamRequest(&request),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         absl::StrCat("chunk_count is ", count, ", allowed: 0 to 64")));
  }
}

TEST(ConvertStepTest, FullResponsesFitTheirLimitAndOneMoreRowWouldNot) {
  const int64_t limit = kResponseBytesDefault;
  StreamRequest request = WholeStep(1000);
  for (const bool with_final : {false, true}) {
    request.request.with_final_observations = with_final;
    const int32_t rows = *ResponseRowsMax("limit", request.request, CodingOf(64), limit);
    FrameBufferPool frames;
    Response response;
    const Batch batch =
        PrepareResponse(request.request, {600, rows}, kObservationBytes, &frames, &response);
    std::fill(batch.first.begin(), batch.first.end(), 1);
    std::fill(batch.terminated.begin(), batch.terminated.end(), 1);
    CompleteResponse(kObservationBytes, batch, &response.message);
    EXPECT_LE(Serialized(response).Length(), static_cast<size_t>(limit));
    PrepareResponse(request.request, {600, rows + 1}, kObservationBytes, &frames, &response);
    EXPECT_GT(Serialized(response).Length() + 256, static_cast<size_t>(limit));
    EXPECT_EQ(rows, with_final ? 170 : 340);
  }
}

TEST(ConvertStepTest, RowLimitFollowsTheObservationSize) {
  const StreamRequest request = WholeStep(1000);
  constexpr int64_t kLarge = 512 * 512 * 3;
  EXPECT_EQ(*ResponseRowsMax("limit", request.request, CodingOf(97), kResponseBytesDefault), 148);
  EXPECT_EQ(*ResponseRowsMax("limit", request.request, CodingOf(512), kResponseBytesDefault), 5);
  FrameBufferPool frames;
  Response response;
  const Batch batch = PrepareResponse(request.request, {0, 5}, kLarge, &frames, &response);
  EXPECT_EQ(batch.observations.size(), 5U * kLarge);
  EXPECT_LE(Serialized(response).Length(), static_cast<size_t>(kResponseBytesDefault));
}

TEST(ConvertStepTest, RowBeyondAResponseIsRejected) {
  StreamRequest request = WholeStep(1);
  const ObservationCoding large = CodingOf(512);
  EXPECT_EQ(*ResponseRowsMax("limit", request.request, large, 786720), 1);
  EXPECT_THAT(ResponseRowsMax("attach.response_bytes_max", request.request, large, 786719),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "the answer for one environment has 1 x 786432 bytes of observations and "
                       "needs 786720, limit attach.response_bytes_max is 786719"));
  request.request.with_final_observations = true;
  EXPECT_THAT(ResponseRowsMax("limit", request.request, large, 786720),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("2 x 786432")));
  request.request.with_observations = false;
  request.request.with_final_observations = false;
  EXPECT_THAT(ResponseRowsMax("limit", request.request, large, 65536), IsOk());
}

TEST(ConvertStepTest, RowsLeaveRoomForIncompressibleObservations) {
  StreamRequest request = WholeStep(1000);
  constexpr int64_t kLimit = kResponseBytesDefault;
  const ObservationCoding coding = CodingOf(64, Encoding::kDeltaZstd);
  request.request.with_final_observations = false;
  const int64_t rows = *ResponseRowsMax("limit", request.request, coding, kLimit);
  EXPECT_LE(rows * coding.sent_bytes_max(), kLimit);
  EXPECT_THAT(rows, testing::AllOf(testing::Gt(300), testing::Lt(340)));
  request.request.with_final_observations = true;
  const int64_t with_final = *ResponseRowsMax("limit", request.request, coding, kLimit);
  EXPECT_LE(with_final * (coding.sent_bytes_max() + kObservationBytes), kLimit);
  EXPECT_GT(with_final, 150) << "final observations are never encoded";
}

}  // namespace
}  // namespace procgen
