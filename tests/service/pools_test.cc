// Creating, finding and deleting pools over gRPC.

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class PoolsTest : public ServiceTest {};

TEST_F(PoolsTest, CreatePoolReturnsTheSpecWithAllDefaults) {
  v1::PoolSpec spec;
  spec.add_games("coinrun");
  spec.set_env_count(3);
  const absl::StatusOr<v1::Pool> pool = client_->CreatePool(spec, "mine");
  ASSERT_THAT(pool, IsOk());
  EXPECT_EQ(pool->name(), "pools/mine");
  EXPECT_EQ(pool->spec().options().distribution_mode(), v1::DISTRIBUTION_MODE_HARD);
  EXPECT_TRUE(pool->spec().options().has_rand_seed());
  EXPECT_TRUE(pool->spec().options().center_agent());
  EXPECT_EQ(pool->spec().total_env_count(), 3);
  EXPECT_EQ(pool->spec().autoreset_mode(), v1::AUTORESET_MODE_SAME_STEP);
  EXPECT_THAT(pool->observation_shape(), ElementsAre(64, 64, 3));
  EXPECT_EQ(pool->observation_bytes(), 12288);
  EXPECT_EQ(pool->next_sequence_number(), 1);
  EXPECT_FALSE(pool->attached());
  EXPECT_GT(pool->create_time().seconds(), 0);
}

TEST_F(PoolsTest, ReturnedSpecCreatesAnEqualPool) {
  v1::PoolSpec spec;
  spec.add_games("maze");
  spec.set_env_count(4);
  const absl::StatusOr<v1::Pool> first = client_->CreatePool(spec);
  ASSERT_THAT(first, IsOk());
  const absl::StatusOr<v1::Pool> second = client_->CreatePool(first->spec());
  ASSERT_THAT(second, IsOk());
  EXPECT_EQ(first->spec().SerializeAsString(), second->spec().SerializeAsString());
  procgen_client::Batch first_batch;
  procgen_client::Batch second_batch;
  EXPECT_THAT((*client_->Attach(first->name()))->Observe(&first_batch), IsOk());
  EXPECT_THAT((*client_->Attach(second->name()))->Observe(&second_batch), IsOk());
  EXPECT_EQ(first_batch.level_seeds(), second_batch.level_seeds());
}

TEST_F(PoolsTest, PoolIsListedUntilItIsDeleted) {
  const std::string name = CreatePool(MazeSpec(1));
  absl::StatusOr<std::vector<v1::Pool>> pools = client_->ListPools();
  ASSERT_THAT(pools, IsOk());
  ASSERT_EQ(pools->size(), 2U);  // the first is the control learner's
  EXPECT_TRUE(pools->front().attached());
  EXPECT_EQ(pools->back().name(), name);
  EXPECT_THAT(client_->DeletePool(name), IsOk());
  EXPECT_THAT(client_->GetPool(name),
              StatusIs(absl::StatusCode::kNotFound, "there is no pool " + name));
  EXPECT_THAT(client_->DeletePool(name), StatusIs(absl::StatusCode::kNotFound, HasSubstr(name)));
}

TEST_F(PoolsTest, ListPoolsReturnsPages) {
  CreatePool(MazeSpec(1));
  CreatePool(MazeSpec(1));
  const auto stub = v1::PoolService::NewStub(channel_);
  v1::ListPoolsRequest request;
  request.set_page_size(2);
  v1::ListPoolsResponse page;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(stub->ListPools(&context, request, &page).ok());
  }
  EXPECT_EQ(page.pools_size(), 2);
  request.set_page_token(page.next_page_token());
  {
    grpc::ClientContext context;
    ASSERT_TRUE(stub->ListPools(&context, request, &page).ok());
  }
  EXPECT_EQ(page.pools_size(), 1);
  EXPECT_EQ(page.next_page_token(), "");
  request.set_page_token("nonsense");
  grpc::ClientContext context;
  EXPECT_EQ(stub->ListPools(&context, request, &page).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(PoolsTest, UnknownGameIsNotFound) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.set_games(0, "chess");
  EXPECT_THAT(client_->CreatePool(spec), StatusIs(absl::StatusCode::kNotFound, HasSubstr("chess")));
}

TEST_F(PoolsTest, ModeThatAGameDoesNotSupportIsRejected) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EXTREME);
  EXPECT_THAT(client_->CreatePool(spec), StatusIs(absl::StatusCode::kInvalidArgument,
                                                  AllOf(HasSubstr("maze"), HasSubstr("extreme"))));
}

TEST_F(PoolsTest, CountsOutOfRangeAreRejected) {
  EXPECT_THAT(client_->CreatePool(MazeSpec(0)), StatusIs(absl::StatusCode::kInvalidArgument,
                                                         "spec.env_count is 0, allowed: 1 to 500"));
  EXPECT_THAT(
      client_->CreatePool(MazeSpec(-1)),
      StatusIs(absl::StatusCode::kInvalidArgument, "spec.env_count is -1, allowed: 1 to 500"));
  v1::PoolSpec spec = MazeSpec(1);
  spec.mutable_options()->set_start_level(-5);
  EXPECT_THAT(client_->CreatePool(spec),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("start_level is -5")));
}

TEST_F(PoolsTest, MalformedNameIsRejected) {
  EXPECT_THAT(client_->GetPool("maze"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "pool name is 'maze', allowed: 'pools/ID', with an ID of 1 to 63 of a-z, "
                       "0-9 and '-'"));
}

TEST_F(PoolsTest, LeaseIsReturnedAndRenewed) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.mutable_lease_duration()->set_seconds(600);
  const absl::StatusOr<v1::Pool> pool = client_->CreatePool(spec);
  ASSERT_THAT(pool, IsOk());
  EXPECT_EQ(pool->spec().lease_duration().seconds(), 600);
  EXPECT_GE(pool->expire_time().seconds(), pool->create_time().seconds() + 600);
  const absl::StatusOr<v1::Pool> renewed = client_->RenewPool(pool->name(), absl::Hours(2));
  ASSERT_THAT(renewed, IsOk());
  EXPECT_EQ(renewed->spec().lease_duration().seconds(), 7200);
  EXPECT_GE(renewed->expire_time().seconds(), pool->create_time().seconds() + 7200);
  EXPECT_THAT(client_->RenewPool(pool->name()), IsOk());
  const auto stream = client_->Attach(pool->name());
  ASSERT_THAT(stream, IsOk());
  EXPECT_FALSE((*stream)->pool().has_expire_time());
}

TEST_F(PoolsTest, LeaseHasADefault) {
  const absl::StatusOr<v1::Pool> pool = client_->CreatePool(MazeSpec(1));
  ASSERT_THAT(pool, IsOk());
  EXPECT_EQ(pool->spec().lease_duration().seconds(), 600);
  EXPECT_GE(pool->expire_time().seconds(), pool->create_time().seconds() + 600);
  const absl::StatusOr<v1::Catalog> catalog = client_->GetCatalog();
  ASSERT_THAT(catalog, IsOk());
  EXPECT_EQ(catalog->limits().lease_duration_default().seconds(), 600);
}

TEST_F(PoolsTest, PoolWithoutALeaseDoesNotExpireUntilItGetsOne) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.mutable_lease_duration();
  const std::string name = CreatePool(spec);
  const absl::StatusOr<v1::Pool> renewed = client_->RenewPool(name);
  ASSERT_THAT(renewed, IsOk());
  EXPECT_FALSE(renewed->has_expire_time());
  EXPECT_TRUE(renewed->spec().has_lease_duration());
  EXPECT_EQ(renewed->spec().lease_duration().seconds(), 0);
  EXPECT_TRUE(client_->RenewPool(name, absl::Hours(1))->has_expire_time());
  EXPECT_FALSE(client_->RenewPool(name, absl::ZeroDuration())->has_expire_time());
}

TEST_F(PoolsTest, LeaseOutOfRangeIsRejected) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.mutable_lease_duration()->set_nanos(1'000'000);
  EXPECT_THAT(client_->CreatePool(spec),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "spec.lease_duration is 1ms, allowed: 0 (no lease), or 1s to 24h"));
  EXPECT_THAT(client_->RenewPool(CreatePool(MazeSpec(1)), absl::Hours(25)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "lease_duration is 25h, limit lease_duration_max is 24h"));
  EXPECT_THAT(client_->RenewPool("pools/nobody"),
              StatusIs(absl::StatusCode::kNotFound, "there is no pool pools/nobody"));
}

TEST_F(PoolsTest, LoadCountsPoolsAndStreams) {
  CreatePool(MazeSpec(5));
  const absl::StatusOr<v1::Load> load = client_->GetLoad();
  ASSERT_THAT(load, IsOk());
  EXPECT_EQ(load->pool_count(), 2);
  EXPECT_EQ(load->env_count(), 7);
  EXPECT_EQ(load->stream_count(), 1);
  EXPECT_EQ(load->worker_count(), 2);
  EXPECT_FALSE(load->draining());
}

TEST_F(PoolsTest, CatalogReturnsTheLimits) {
  const absl::StatusOr<v1::Catalog> catalog = client_->GetCatalog();
  ASSERT_THAT(catalog, IsOk());
  EXPECT_EQ(catalog->limits().pool_count_max(), 4);
  EXPECT_EQ(catalog->limits().requests_in_flight_max(), 8);
}

}  // namespace
}  // namespace procgen
