#include "server/pool/pool_registry.h"

#include <string>
#include <utility>

#include "gtest/gtest.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

// Names only; PoolSupervisorTest covers registered pools.
class PoolRegistryTest : public testing::Test {
 protected:
  absl::StatusOr<PoolRegistry::Key> Reserve(const std::string& id) {
    absl::StatusOr<Quotas::Reservation> reservation = quotas_.Reserve("alice", {.env_count = 1});
    return registry_.Reserve("alice", id, *std::move(reservation));
  }

  Quotas quotas_{Limits()};
  PoolRegistry registry_;  // destroyed before the quotas of its reservations
};

TEST_F(PoolRegistryTest, NameIsReservedWhileItsPoolIsCreated) {
  ASSERT_THAT(Reserve("a"), IsOk());
  EXPECT_THAT(Reserve("a"), StatusIs(absl::StatusCode::kAlreadyExists,
                                     "pool pools/a exists; choose another pool_id"));
  EXPECT_EQ(quotas_.env_count(), 1) << "without a name there is no reservation";
  EXPECT_THAT(registry_.Find("alice", "pools/a"),
              StatusIs(absl::StatusCode::kNotFound, "there is no pool pools/a"));
  EXPECT_TRUE(registry_.All().empty());
  EXPECT_TRUE(registry_.List("alice", 0, 9).empty());
}

TEST_F(PoolRegistryTest, FailedCreationFreesNameAndReservation) {
  const absl::StatusOr<PoolRegistry::Key> key = Reserve("a");
  ASSERT_THAT(key, IsOk());
  registry_.Remove(*key);
  EXPECT_EQ(quotas_.env_count(), 0);
  EXPECT_THAT(Reserve("a"), IsOk());
}

TEST_F(PoolRegistryTest, ChosenNamesAreUnique) {
  const absl::StatusOr<PoolRegistry::Key> first = Reserve("");
  ASSERT_THAT(first, IsOk());
  EXPECT_EQ(first->second, "pools/1");
  registry_.Remove(*first);
  const absl::StatusOr<PoolRegistry::Key> second = Reserve("");
  ASSERT_THAT(second, IsOk());
  EXPECT_EQ(second->second, "pools/2");
}

}  // namespace
}  // namespace procgen
