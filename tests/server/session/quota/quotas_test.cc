#include "server/session/quota/quotas.h"

#include <memory>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

Limits SmallQuotas() {
  Limits limits;
  limits.owner_pool_count_max = 2;
  limits.owner_env_count_max = 10;
  limits.owner_stream_count_max = 1;
  limits.owner_call_count_max = 3;
  return limits;
}

TEST(QuotasTest, EachQuotaIsNamedWithItsOwnerAndValues) {
  Quotas quotas(SmallQuotas());
  const auto held = quotas.Reserve(
      "alice", {.pool_count = 2, .env_count = 9, .stream_count = 1, .call_count = 3});
  ASSERT_THAT(held, IsOk());
  EXPECT_THAT(quotas.Reserve("alice", {.pool_count = 1}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 2 pools and asks for 1 more, limit owner_pool_count_max "
                       "is 2"));
  EXPECT_THAT(quotas.Reserve("alice", {.env_count = 2}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 9 environments and asks for 2 more, limit "
                       "owner_env_count_max is 10"));
  EXPECT_THAT(quotas.Reserve("alice", {.stream_count = 1}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 1 streams and asks for 1 more, limit "
                       "owner_stream_count_max is 1"));
  EXPECT_THAT(quotas.Reserve("alice", {.call_count = 1}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 3 calls under way and asks for 1 more, limit "
                       "owner_call_count_max is 3"));
}

TEST(QuotasTest, QuotasArePerOwner) {
  Quotas quotas(SmallQuotas());
  const auto alice = quotas.Reserve("alice", {.stream_count = 1});
  EXPECT_THAT(quotas.Reserve("bob", {.stream_count = 1}), IsOk());
  EXPECT_THAT(quotas.Reserve("", {.stream_count = 1}), IsOk());
  EXPECT_FALSE(quotas.Reserve("alice", {.stream_count = 1}).ok());
}

TEST(QuotasTest, ReturnedQuotaIsAvailable) {
  Quotas quotas(SmallQuotas());
  for (int round = 0; round < 100; ++round) {
    auto reservation = quotas.Reserve("alice", {.env_count = 10});
    ASSERT_THAT(reservation, IsOk());
    Quotas::Reservation moved = *std::move(reservation);
    EXPECT_FALSE(quotas.Reserve("alice", {.env_count = 1}).ok()) << "moved, not released";
    moved = Quotas::Reservation();
    EXPECT_THAT(quotas.Reserve("alice", {.env_count = 1}), IsOk());
  }
}

TEST(QuotasTest, RejectedReservationsTakeNothing) {
  Quotas quotas(SmallQuotas());
  EXPECT_FALSE(quotas.Reserve("alice", {.pool_count = 1, .env_count = 11}).ok());
  EXPECT_THAT(quotas.Reserve("alice", {.pool_count = 2, .env_count = 10}), IsOk());
}

TEST(QuotasTest, OverflowingNumbersAreRejected) {
  Quotas quotas(SmallQuotas());
  const auto held = quotas.Reserve("alice", {.env_count = 5});
  EXPECT_FALSE(quotas.Reserve("alice", {.env_count = INT32_MAX}).ok());
}

TEST(QuotasTest, ValueCountsUntilItsLastReferenceIsReleased) {
  Limits limits;
  limits.owner_buffer_bytes_max = 100;
  Quotas quotas(limits);
  auto held = quotas.Hold("alice", 60, std::make_shared<const int>(7));
  ASSERT_THAT(held, IsOk());
  EXPECT_EQ(**held, 7);
  std::shared_ptr<const int> other = *held;
  held = nullptr;
  EXPECT_THAT(quotas.Reserve("alice", {.buffer_bytes = 41}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 60 bytes of requests, responses and level samplers and "
                       "asks for 41 more, limit owner_buffer_bytes_max is 100"));
  other = nullptr;
  EXPECT_THAT(quotas.Reserve("alice", {.buffer_bytes = 100}), IsOk());
}

TEST(QuotasTest, LargeFreesAreReported) {
  int frees = 0;
  Quotas quotas(Limits(), [&frees] { ++frees; });
  quotas.Reserve("alice", {.buffer_bytes = kLargeBufferBytes - 1}).status().IgnoreError();
  EXPECT_EQ(frees, 0);
  quotas.Reserve("alice", {.buffer_bytes = kLargeBufferBytes}).status().IgnoreError();
  EXPECT_EQ(frees, 1);
}

}  // namespace
}  // namespace procgen
