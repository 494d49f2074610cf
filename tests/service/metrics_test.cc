// The server's metrics equal what the clients did.

#include "server/metrics/metrics.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr absl::string_view kMethod = "PoolService/RunPool";

class ServedMetricsTest : public ServiceTest {
 protected:
  std::string Text() const { return server_->metrics().Text(); }
};

std::string Error(const std::string& code, const std::string& method, int count) {
  return absl::StrCat("procgen_errors_total{code=\"", code, "\",method=\"", method, "\"} ", count,
                      "\n");
}

TEST_F(ServedMetricsTest, ErrorsAreCountedByMethodAndCode) {
  EXPECT_THAT(Text(), Not(HasSubstr("procgen_errors_total{")));
  EXPECT_THAT(client_->GetPool("pools/nobody"), StatusIs(absl::StatusCode::kNotFound, testing::_));
  EXPECT_THAT(client_->GetPool("pools/nobody"), StatusIs(absl::StatusCode::kNotFound, testing::_));
  EXPECT_THAT(client_->GetPool("nobody"), StatusIs(absl::StatusCode::kInvalidArgument, testing::_));
  EXPECT_THAT(StartError(MazeSpec(0)), StatusIs(absl::StatusCode::kInvalidArgument, testing::_));
  const auto stream = StartPool(MazeSpec(1));
  EXPECT_THAT(stream->Call(StepRequest({99})),
              StatusIs(absl::StatusCode::kInvalidArgument, testing::_));
  EXPECT_THAT(client_->GetLoad(), IsOk());
  EXPECT_THAT(Text(), AllOf(HasSubstr(Error("NOT_FOUND", "PoolService/GetPool", 2)),
                            HasSubstr(Error("INVALID_ARGUMENT", "PoolService/GetPool", 1)),
                            HasSubstr(Error("INVALID_ARGUMENT", std::string(kMethod), 2)),
                            Not(HasSubstr("GetLoad"))));
}

TEST_F(ServedMetricsTest, LoadAndPoolsReturnTheCounts) {
  const auto stream = StartPool(MazeSpec(4));
  v1::Batch batch;
  for (int i = 0; i < 3; ++i) {
    ASSERT_THAT(stream->Step({4, 4, 4, 4}, &batch), IsOk());
  }
  const auto load = client_->GetLoad();
  ASSERT_THAT(load, IsOk());
  EXPECT_EQ(load->step_count(), 12);
  EXPECT_EQ(client_->GetPool(stream->name())->step_count(), 12);
  for (const v1::LatencyHistogram& latency : {load->queue_wait(), load->execution_time()}) {
    EXPECT_EQ(latency.counts_size(), latency.bounds_seconds_size() + 1);
    int64_t count = 0;
    for (const int64_t counted : latency.counts()) {
      count += counted;
    }
    EXPECT_EQ(count, 3);
    EXPECT_GT(latency.sum_seconds(), 0);
  }
  const StreamTotals totals = server_->metrics().stream_totals();
  EXPECT_EQ(load->stream_received_bytes(), totals.received_bytes);
  EXPECT_EQ(load->stream_sent_bytes(), totals.sent_bytes);
  EXPECT_GE(load->stream_sent_bytes(), 3 * static_cast<int64_t>(batch.observations().size()));
}

}  // namespace
}  // namespace procgen
