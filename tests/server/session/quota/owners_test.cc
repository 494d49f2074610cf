#include "server/session/quota/owners.h"

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

TEST(OwnersTest, EachQuotaIsNamedWithItsOwnerAndValues) {
  Owners owners(SmallQuotas());
  const auto held =
      owners.Take("alice", {.pool_count = 2, .env_count = 9, .stream_count = 1, .call_count = 3});
  ASSERT_THAT(held, IsOk());
  EXPECT_THAT(owners.Take("alice", {.pool_count = 1}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 2 pools and asks for 1 more, limit owner_pool_count_max "
                       "is 2"));
  EXPECT_THAT(owners.Take("alice", {.env_count = 2}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 9 environments and asks for 2 more, limit "
                       "owner_env_count_max is 10"));
  EXPECT_THAT(owners.Take("alice", {.stream_count = 1}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 1 streams and asks for 1 more, limit "
                       "owner_stream_count_max is 1"));
  EXPECT_THAT(owners.Take("alice", {.call_count = 1}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 3 calls under way and asks for 1 more, limit "
                       "owner_call_count_max is 3"));
}

TEST(OwnersTest, OwnersHaveQuotasOfTheirOwn) {
  Owners owners(SmallQuotas());
  const auto alice = owners.Take("alice", {.stream_count = 1});
  EXPECT_THAT(owners.Take("bob", {.stream_count = 1}), IsOk());
  EXPECT_THAT(owners.Take("", {.stream_count = 1}), IsOk());
  EXPECT_FALSE(owners.Take("alice", {.stream_count = 1}).ok());
}

TEST(OwnersTest, WhatIsGivenBackCanBeTakenAgain) {
  Owners owners(SmallQuotas());
  for (int round = 0; round < 100; ++round) {
    auto share = owners.Take("alice", {.env_count = 10});
    ASSERT_THAT(share, IsOk());
    Owners::Share moved = *std::move(share);
    EXPECT_FALSE(owners.Take("alice", {.env_count = 1}).ok()) << "moved, not given back";
    moved = Owners::Share();
    EXPECT_THAT(owners.Take("alice", {.env_count = 1}), IsOk());
  }
}

TEST(OwnersTest, RefusedPartsTakeNothing) {
  Owners owners(SmallQuotas());
  EXPECT_FALSE(owners.Take("alice", {.pool_count = 1, .env_count = 11}).ok());
  EXPECT_THAT(owners.Take("alice", {.pool_count = 2, .env_count = 10}), IsOk());
}

TEST(OwnersTest, NumbersThatOverflowAreRefused) {
  Owners owners(SmallQuotas());
  const auto held = owners.Take("alice", {.env_count = 5});
  EXPECT_FALSE(owners.Take("alice", {.env_count = INT32_MAX}).ok());
}

TEST(OwnersTest, AHeldValueCountsUntilItsLastReferenceGoes) {
  Limits limits;
  limits.owner_buffer_bytes_max = 100;
  Owners owners(limits);
  auto held = owners.Hold("alice", 60, std::make_shared<const int>(7));
  ASSERT_THAT(held, IsOk());
  EXPECT_EQ(**held, 7);
  std::shared_ptr<const int> other = *held;
  held = nullptr;
  EXPECT_THAT(owners.Take("alice", {.buffer_bytes = 41}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 60 bytes of requests, responses and level samplers and "
                       "asks for 41 more, limit owner_buffer_bytes_max is 100"));
  other = nullptr;
  EXPECT_THAT(owners.Take("alice", {.buffer_bytes = 100}), IsOk());
}

TEST(OwnersTest, LargeFreesAreReported) {
  int frees = 0;
  Owners owners(Limits(), [&frees] { ++frees; });
  owners.Take("alice", {.buffer_bytes = kLargeBufferBytes - 1}).status().IgnoreError();
  EXPECT_EQ(frees, 0);
  owners.Take("alice", {.buffer_bytes = kLargeBufferBytes}).status().IgnoreError();
  EXPECT_EQ(frees, 1);
}

}  // namespace
}  // namespace procgen
