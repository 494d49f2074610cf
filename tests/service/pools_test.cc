// Creating, finding and listing pools over gRPC.

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

TEST_F(PoolsTest, PoolHasASpecWithAllDefaults) {
  v1::PoolSpec spec;
  spec.add_games("coinrun");
  spec.set_env_count(3);
  const auto stream = StartPool(spec, "mine");
  const v1::Pool& pool = stream->pool();
  EXPECT_EQ(pool.name(), "pools/mine");
  EXPECT_EQ(pool.spec().options().distribution_mode(), v1::DISTRIBUTION_MODE_HARD);
  EXPECT_TRUE(pool.spec().options().has_rand_seed());
  EXPECT_TRUE(pool.spec().options().center_agent());
  EXPECT_EQ(pool.spec().total_env_count(), 3);
  EXPECT_EQ(pool.spec().autoreset_mode(), v1::AUTORESET_MODE_SAME_STEP);
  EXPECT_THAT(pool.observation_shape(), ElementsAre(64, 64, 3));
  EXPECT_EQ(pool.observation_bytes(), 12288);
  EXPECT_GT(pool.create_time().seconds(), 0);
  const absl::StatusOr<v1::Pool> same = client_->GetPool("pools/mine");
  ASSERT_THAT(same, IsOk());
  EXPECT_TRUE(EqualMessages(same->spec(), pool.spec()));
}

TEST_F(PoolsTest, ReturnedSpecCreatesAnEqualPool) {
  v1::PoolSpec spec;
  spec.add_games("maze");
  spec.set_env_count(4);
  const auto first = StartPool(spec);
  const auto second = StartPool(first->pool().spec());
  EXPECT_TRUE(EqualMessages(first->pool().spec(), second->pool().spec()));
  v1::Batch first_batch;
  v1::Batch second_batch;
  EXPECT_THAT(first->Observe(&first_batch), IsOk());
  EXPECT_THAT(second->Observe(&second_batch), IsOk());
  EXPECT_TRUE(EqualMessages(first_batch, second_batch));
}

TEST_F(PoolsTest, PoolIsListedUntilItEnds) {
  const auto stream = StartPool(MazeSpec(1));
  absl::StatusOr<std::vector<v1::Pool>> pools = client_->ListPools();
  ASSERT_THAT(pools, IsOk());
  ASSERT_EQ(pools->size(), 2U);  // the first is the control learner's
  EXPECT_EQ(pools->back().name(), stream->name());
  EXPECT_THAT(stream->Close(), IsOk());
  pools = client_->ListPools();
  ASSERT_THAT(pools, IsOk());
  EXPECT_EQ(pools->size(), 1U);
}

TEST_F(PoolsTest, ListPoolsReturnsPages) {
  const auto first = StartPool(MazeSpec(1));
  const auto second = StartPool(MazeSpec(1));
  const auto stub = v1::PoolService::NewStub(channel_);
  v1::ListPoolsRequest request;
  v1::ListPoolsResponse page;
  const auto list = [&] {
    grpc::ClientContext context;
    return stub->ListPools(&context, request, &page).error_code();
  };
  request.set_page_size(2);
  EXPECT_EQ(list(), grpc::StatusCode::OK);
  EXPECT_EQ(page.pools_size(), 2);
  request.set_page_token(page.next_page_token());
  EXPECT_EQ(list(), grpc::StatusCode::OK);
  EXPECT_EQ(page.pools_size(), 1);
  EXPECT_EQ(page.next_page_token(), "");
  request.set_page_token("nonsense");
  EXPECT_EQ(list(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(PoolsTest, UnknownGameIsNotFound) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.set_games(0, "chess");
  EXPECT_THAT(StartError(spec), StatusIs(absl::StatusCode::kNotFound, HasSubstr("chess")));
}

TEST_F(PoolsTest, ModeThatAGameDoesNotSupportIsRejected) {
  v1::PoolSpec spec = MazeSpec(1);
  spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EXTREME);
  EXPECT_THAT(StartError(spec), StatusIs(absl::StatusCode::kInvalidArgument,
                                         AllOf(HasSubstr("maze"), HasSubstr("extreme"))));
}

TEST_F(PoolsTest, CountsOutOfRangeAreRejected) {
  EXPECT_THAT(StartError(MazeSpec(0)), StatusIs(absl::StatusCode::kInvalidArgument,
                                                "spec.env_count is 0, allowed: at least 1"));
  EXPECT_THAT(StartError(MazeSpec(-1)), StatusIs(absl::StatusCode::kInvalidArgument,
                                                 "spec.env_count is -1, allowed: at least 1"));
  v1::PoolSpec spec = MazeSpec(1);
  spec.mutable_options()->set_start_level(-5);
  EXPECT_THAT(StartError(spec),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("start_level is -5")));
}

TEST_F(PoolsTest, MalformedNameIsRejected) {
  EXPECT_THAT(client_->GetPool("maze"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "pool name is 'maze', allowed: 'pools/ID', with an ID of 1 to 63 of a-z, "
                       "0-9 and '-'"));
}

TEST_F(PoolsTest, LoadCountsPoolsAndEnvironments) {
  const auto stream = StartPool(MazeSpec(5));
  const absl::StatusOr<v1::Load> load = client_->GetLoad();
  ASSERT_THAT(load, IsOk());
  EXPECT_EQ(load->pool_count(), 2);
  EXPECT_EQ(load->env_count(), 7);
  EXPECT_EQ(load->worker_count(), 2);
  EXPECT_FALSE(load->draining());
}

TEST_F(PoolsTest, CatalogReturnsTheLimits) {
  const absl::StatusOr<v1::Catalog> catalog = client_->GetCatalog();
  ASSERT_THAT(catalog, IsOk());
  EXPECT_EQ(catalog->limits().env_count_max(), 600);
  EXPECT_EQ(catalog->limits().request_bytes_max(), 65536);
}

}  // namespace
}  // namespace procgen
