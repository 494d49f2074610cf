#include "server/pool/quota/quotas.h"

#include <memory>
#include <utility>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

Limits SmallQuotas() {
  Limits limits;
  limits.env_count_max = 12;
  limits.owner_env_count_max = 10;
  limits.owner_bytes_max = 100;
  limits.owner_call_count_max = 3;
  return limits;
}

TEST(QuotasTest, EachQuotaIsNamedWithItsOwnerAndValues) {
  Quotas quotas(SmallQuotas());
  const auto held = quotas.Reserve("alice", {.env_count = 9, .bytes = 60, .call_count = 3});
  ASSERT_THAT(held, IsOk());
  EXPECT_THAT(quotas.Reserve("alice", {.env_count = 2}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 9 environments and asks for 2 more, limit "
                       "owner_env_count_max is 10"));
  EXPECT_THAT(quotas.Reserve("alice", {.bytes = 41}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 60 bytes of pools and level samplers and asks for 41 more, "
                       "limit owner_bytes_max is 100"));
  EXPECT_THAT(quotas.Reserve("alice", {.call_count = 1}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 3 calls in progress and asks for 1 more, limit "
                       "owner_call_count_max is 3"));
  EXPECT_THAT(quotas.Reserve("", {.call_count = 4}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "every caller together has 0 calls in progress and asks for 4 more, limit "
                       "owner_call_count_max is 3"));
}

TEST(QuotasTest, QuotasArePerOwnerAndEnvironmentsAlsoOfTheServer) {
  Quotas quotas(SmallQuotas());
  const auto alice = quotas.Reserve("alice", {.env_count = 10, .call_count = 3});
  EXPECT_EQ(quotas.env_count(), 10);
  EXPECT_THAT(quotas.Reserve("bob", {.env_count = 2, .call_count = 3}), IsOk());
  EXPECT_THAT(quotas.Reserve("", {.env_count = 2, .call_count = 3}), IsOk());
  EXPECT_THAT(quotas.Reserve("bob", {.env_count = 3}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "the server has 10 environments and is asked for 3 more, limit "
                       "env_count_max is 12"));
  EXPECT_EQ(quotas.env_count(), 10);
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
  EXPECT_FALSE(quotas.Reserve("alice", {.env_count = 10, .call_count = 4}).ok());
  EXPECT_THAT(quotas.Reserve("alice", {.env_count = 10, .call_count = 3}), IsOk());
}

TEST(QuotasTest, OverflowingNumbersAreRejected) {
  Quotas quotas(SmallQuotas());
  const auto held = quotas.Reserve("alice", {.env_count = 5});
  EXPECT_FALSE(quotas.Reserve("alice", {.env_count = INT32_MAX}).ok());
}

TEST(QuotasTest, ValueCountsUntilItsLastReferenceIsReleased) {
  Quotas quotas(SmallQuotas());
  auto held = quotas.Hold("alice", 60, std::make_shared<const int>(7));
  ASSERT_THAT(held, IsOk());
  EXPECT_EQ(**held, 7);
  std::shared_ptr<const int> other = *held;
  held = nullptr;
  EXPECT_FALSE(quotas.Reserve("alice", {.bytes = 41}).ok());
  other = nullptr;
  EXPECT_THAT(quotas.Reserve("alice", {.bytes = 100}), IsOk());
}

}  // namespace
}  // namespace procgen
