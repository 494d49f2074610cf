// Creating, finding and listing pools over gRPC.

#include <cstdint>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class PoolsTest : public ServiceTest {};

// Ends the episode of each environment `count` times.
void EndEpisodes(PoolStream* stream, int32_t env_count, int32_t count) {
  const auto n = static_cast<size_t>(env_count);
  v1::Batch batch;
  for (int32_t i = 0; i < count; ++i) {
    ASSERT_THAT(stream->Step(std::vector<int32_t>(n, 4), &batch), IsOk());
    ASSERT_THAT(stream->Step(std::vector<int32_t>(n, -1), &batch), IsOk());
  }
}

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

TEST_F(PoolsTest, StatisticsHaveTheReturnsOfEachGame) {
  v1::PoolSpec spec = MazeSpec(3);
  spec.mutable_games()->Clear();
  for (const char* game : {"maze", "chaser", "heist"}) {
    spec.add_games(game);
  }
  const auto stream = StartPool(spec);
  EndEpisodes(stream.get(), 3, 2);
  v1::Batch batch;
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  absl::StatusOr<v1::Pool> pool = client_->GetPool(stream->name());
  ASSERT_THAT(pool, IsOk());
  EXPECT_EQ(pool->episode_count(), 6);
  ASSERT_EQ(pool->game_returns_size(), 3);
  EXPECT_EQ(pool->game_returns(0).game(), "chaser");
  EXPECT_EQ(pool->game_returns(1).game(), "heist");
  EXPECT_EQ(pool->game_returns(2).game(), "maze");
  EXPECT_TRUE(pool->game_returns(2).has_mean_episode_return());
  EXPECT_EQ(pool->game_returns(2).mean_episode_return(), 0);
  EXPECT_LE(pool->min_episode_return(), pool->mean_episode_return());
  EXPECT_GE(pool->max_episode_return(), pool->mean_episode_return());
  const auto single = StartPool(MazeSpec(1));
  pool = client_->GetPool(single->name());
  ASSERT_THAT(pool, IsOk());
  EXPECT_EQ(pool->game_returns_size(), 0);
}

TEST_F(PoolsTest, EndedEpisodesAreListed) {
  const auto stream = StartPool(MazeSpec(2));
  EndEpisodes(stream.get(), 2, 3);
  const auto stub = v1::PoolService::NewStub(channel_);
  v1::ListEpisodesRequest request;
  v1::ListEpisodesResponse response;
  const auto list = [&] {
    grpc::ClientContext context;
    return stub->ListEpisodes(&context, request, &response);
  };
  request.set_pool(stream->name());
  ASSERT_TRUE(list().ok());
  ASSERT_EQ(response.episodes_size(), 6);
  EXPECT_EQ(response.episode_count(), 6);
  EXPECT_EQ(response.recorded_count(), 6);
  const v1::EpisodeSummary& last = response.episodes(5);
  EXPECT_EQ(last.environment(), 1);
  EXPECT_EQ(last.length(), 2);
  EXPECT_FALSE(last.truncated());
  EXPECT_GT(last.end_time().seconds(), 0);
  EXPECT_THAT(client_->FindEpisode(stream->name(), 1, last.fingerprint()), IsOk());
  request.set_after(4);
  ASSERT_TRUE(list().ok());
  EXPECT_EQ(response.episodes_size(), 2);
  EXPECT_EQ(response.episode_count(), 6);
  request.set_after(-1);
  EXPECT_EQ(list().error_message(), "after is -1, allowed: at least 0");
  request.set_after(0);
  request.set_pool("pools/none");
  EXPECT_EQ(list().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(PoolsTest, HistoryHasARowASecond) {
  const auto stream = StartPool(MazeSpec(2));
  EndEpisodes(stream.get(), 2, 1);
  const auto stub = v1::PoolService::NewStub(channel_);
  v1::GetPoolHistoryRequest request;
  v1::PoolHistory history;
  const auto read = [&] {
    grpc::ClientContext context;
    return stub->GetPoolHistory(&context, request, &history);
  };
  request.set_name(stream->name());
  while (history.rows_size() < 2 || history.rows(history.rows_size() - 1).step_count() < 4) {
    ASSERT_TRUE(read().ok());
  }
  EXPECT_EQ(history.interval().seconds(), 1);
  const v1::PoolHistoryRow& row = history.rows(history.rows_size() - 1);
  EXPECT_EQ(row.step_count(), 4);
  EXPECT_EQ(row.episode_count(), 2);
  EXPECT_TRUE(row.has_steps_per_second());
  EXPECT_EQ(row.mean_episode_length(), 2);
  EXPECT_GT(row.request_duration_p50_s(), 0);
  EXPECT_FALSE(history.rows(0).has_steps_per_second());
  EXPECT_GT(row.time().seconds(), 0);
  request.mutable_span()->set_seconds(86'400);
  ASSERT_TRUE(read().ok());
  EXPECT_EQ(history.interval().seconds(), 240);
  EXPECT_GE(history.rows_size(), 2);
  for (const int64_t seconds : {-1, 0, 86'401}) {
    request.mutable_span()->set_seconds(seconds);
    EXPECT_EQ(read().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  }
  request.clear_span();
  request.set_name("pools/none");
  EXPECT_EQ(read().error_code(), grpc::StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace procgen
