#include "server/rpc/services/states_page.h"

#include <memory>
#include <string>
#include <utility>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/server/session/test_pool_context.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;

constexpr int64_t kBytesMax = 65536;

class StatesPageTest : public testing::Test {
 protected:
  StatesPageTest() { request_.set_response_bytes_max(kBytesMax); }

  std::unique_ptr<PoolSession> Make() {
    PoolOptions options;
    options.games = {"maze"};
    options.env_count = 4;
    absl::StatusOr<std::unique_ptr<Pool>> pool =
        Pool::Create(options, std::make_shared<WorkerPool>(1));
    EXPECT_THAT(pool, IsOk());
    return std::make_unique<PoolSession>("", "pools/7", context_.Backend(*std::move(pool)),
                                         absl::InfiniteDuration(), context_.Get());
  }

  absl::StatusOr<std::unique_ptr<StatesPage>> Begin() {
    return StatesPage::Begin(request_, *session_, Limits());
  }

  TestPoolContext context_;
  std::unique_ptr<PoolSession> session_ = Make();
  v1::SaveStatesRequest request_;
  v1::SaveStatesResponse response_;
};

TEST_F(StatesPageTest, NoNamesMeanAll) {
  EXPECT_THAT((*Begin())->rest(), ElementsAre(0, 1, 2, 3));
  request_.add_environments(2);
  EXPECT_THAT((*Begin())->rest(), ElementsAre(2));
}

TEST_F(StatesPageTest, FullPageFitsExactlyAndTheNextContinues) {
  const auto page = Begin();
  ASSERT_THAT(page, IsOk());
  ASSERT_THAT((*page)->Open(5), IsOk());
  ASSERT_TRUE((*page)->Add(0, std::string(30000, 'x'), &response_));
  EXPECT_FALSE((*page)->Add(1, std::string(35500, 'x'), &response_));
  ASSERT_TRUE((*page)->Add(1, std::string(35300, 'x'), &response_));
  ASSERT_THAT((*page)->Close(&response_), IsOk());
  EXPECT_EQ(response_.states_size(), 2);
  EXPECT_LE(response_.ByteSizeLong(), static_cast<size_t>(kBytesMax));

  request_.set_page_token(response_.next_page_token());
  const auto next = Begin();
  ASSERT_THAT(next, IsOk());
  EXPECT_THAT((*next)->Open(5), IsOk());
  EXPECT_THAT((*next)->rest(), ElementsAre(2, 3));
  EXPECT_THAT((*next)->Open(6), StatusIs(absl::StatusCode::kAborted, testing::_));
}

TEST_F(StatesPageTest, TheLastPageHasNoToken) {
  request_.add_environments(3);
  const auto page = Begin();
  ASSERT_THAT((*page)->Open(5), IsOk());
  ASSERT_TRUE((*page)->Add(3, "x", &response_));
  ASSERT_THAT((*page)->Close(&response_), IsOk());
  EXPECT_EQ(response_.next_page_token(), "");
}

TEST_F(StatesPageTest, SnapshotBeyondAPageIsAnError) {
  const auto page = Begin();
  ASSERT_THAT((*page)->Open(5), IsOk());
  EXPECT_FALSE((*page)->Add(0, std::string(kBytesMax, 'x'), &response_));
  EXPECT_THAT((*page)->Close(&response_),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "the snapshot of environment 0 does not fit a response, limit "
                       "response_bytes_max is 65536"));
}

TEST_F(StatesPageTest, PageTokenOfAnEarlierPoolIsRejected) {
  const auto page = Begin();
  ASSERT_THAT((*page)->Open(0), IsOk());
  ASSERT_TRUE((*page)->Add(0, "x", &response_));
  ASSERT_THAT((*page)->Close(&response_), IsOk());
  request_.set_page_token(response_.next_page_token());
  EXPECT_THAT(Begin(), IsOk());
  context_.clock.Advance(absl::Seconds(1));
  session_ = Make();
  EXPECT_THAT(Begin(), StatusIs(absl::StatusCode::kInvalidArgument, testing::_));
}

}  // namespace
}  // namespace procgen
