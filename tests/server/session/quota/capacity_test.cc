#include "server/session/quota/capacity.h"

#include <utility>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

constexpr int64_t kFrameBytes = 100;

Limits SmallLimits() {
  Limits limits;
  limits.pool_count_max = 2;
  limits.pool_env_count_max = 6;
  limits.env_count_max = 10;
  limits.observation_bytes_max = 9 * kFrameBytes;
  return limits;
}

TEST(CapacityTest, EachLimitIsNamedWithItsValues) {
  Capacity capacity(SmallLimits());
  const auto first = capacity.Reserve(5, kFrameBytes);
  ASSERT_THAT(first, IsOk());
  EXPECT_THAT(capacity.Reserve(0, kFrameBytes),
              StatusIs(absl::StatusCode::kInvalidArgument, "spec.env_count is 0, allowed: 1 to 6"));
  EXPECT_THAT(capacity.Reserve(7, kFrameBytes),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "spec.env_count is 7, limit pool_env_count_max is 6"));
  EXPECT_THAT(capacity.Reserve(6, kFrameBytes),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "spec.env_count is 6 and there are 5 environments, limit "
                       "env_count_max is 10"));
  EXPECT_THAT(capacity.Reserve(5, kFrameBytes),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "one observation of each environment takes 500 bytes and those of other "
                       "pools 500, limit observation_bytes_max is 900"));
  const auto second = capacity.Reserve(1, kFrameBytes);
  ASSERT_THAT(second, IsOk());
  EXPECT_THAT(capacity.Reserve(1, kFrameBytes),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "there are 2 pools, limit pool_count_max is 2"));
}

TEST(CapacityTest, AReservationIsReleasedOnceHoweverItWasMoved) {
  Capacity capacity(SmallLimits());
  Capacity::Reservation other = *capacity.Reserve(3, kFrameBytes);
  {
    Capacity::Reservation held = *capacity.Reserve(6, kFrameBytes);
    EXPECT_EQ(capacity.env_count(), 9);
    other = std::move(held);
  }
  EXPECT_EQ(capacity.env_count(), 6) << "the moved reservation of three was released";
  other = Capacity::Reservation();
  EXPECT_EQ(capacity.env_count(), 0);
  EXPECT_THAT(capacity.Reserve(6, kFrameBytes), IsOk());
}

TEST(CapacityTest, PoolsThatExistCountAlsoBeyondTheLimits) {
  Capacity capacity(SmallLimits());
  const Capacity::Reservation restored = capacity.Count(12, kFrameBytes);
  EXPECT_EQ(capacity.env_count(), 12);
  EXPECT_THAT(capacity.Reserve(1, kFrameBytes),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "spec.env_count is 1 and there are 12 environments, limit "
                       "env_count_max is 10"));
}

}  // namespace
}  // namespace procgen
