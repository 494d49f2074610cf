#include "server/pool/watch/frame_publisher.h"

#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/pool/watch/frame_publishers.h"
#include "tests/server/pool/test_pool_context.h"
#include "tests/server/pool/test_sink.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr int32_t kWatchedCount = 2;
constexpr int32_t kNoAction = 4;

// Frame sets in the order in which they were published.
class FrameSets final : public FrameSubscriber, public std::enable_shared_from_this<FrameSets> {
 public:
  bool IsReady() override { return true; }
  void Take(const absl::Cord& /*frame_set*/) override {}
  void End(const absl::Status& /*reason*/) override {}

  // A publisher may encode frames after the subscription has ended.
  FrameSetEncoder Encoder() {
    return [self = shared_from_this()](FrameSet frame_set) {
      absl::MutexLock lock(&self->mutex_);
      self->frame_sets_.push_back(std::move(frame_set));
      return absl::Cord("encoded");
    };
  }
  FrameSet Next() {
    absl::MutexLock lock(&mutex_);
    const auto is_there = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return !frame_sets_.empty();
    };
    mutex_.Await(absl::Condition(&is_there));
    FrameSet next = std::move(frame_sets_.front());
    frame_sets_.pop_front();
    return next;
  }

 private:
  absl::Mutex mutex_;
  std::deque<FrameSet> frame_sets_ ABSL_GUARDED_BY(mutex_);
};

class FramePublisherTest : public testing::Test {
 protected:
  void SetUp() override {
    PoolOptions options;
    options.games = {"maze"};
    options.env_count = kWatchedCount;
    absl::StatusOr<std::unique_ptr<Pool>> pool = Pool::Create(options, workers_);
    ASSERT_THAT(pool, IsOk());
    session_ = std::make_shared<PoolSession>(
        "", "pools/7", *std::move(pool), SessionOptions(), [](const absl::Status&) {},
        context_.Get());
  }
  void TearDown() override {
    publishers_.Unsubscribe(frame_sets_.get());
    session_->Close(absl::CancelledError());
  }

  // Watches environments 1 and 0, in this order.
  void Watch(int32_t size_px, bool with_steps = false) {
    const WatchSpec spec = {.environments = {1, 0},
                            .size_px = size_px,
                            .interval = absl::Milliseconds(1),
                            .format = 0,
                            .with_steps = with_steps};
    ASSERT_THAT(publishers_.Subscribe(session_, spec, frame_sets_->Encoder(), frame_sets_), IsOk());
    frame_sets_->Next();
  }

  // Steps both environments; the observations are in observations_ and final_observations_.
  void Step(const std::vector<int32_t>& actions, absl::Span<const Annotation> annotations = {}) {
    Request request = RequestOf(Request::Kind::kStep, kWatchedCount);
    request.actions = actions;
    request.annotations = annotations;
    Batch batch;
    batch.observations = absl::MakeSpan(observations_);
    batch.final_observations = absl::MakeSpan(final_observations_);
    ASSERT_THAT(Execute(session_.get(), request, batch), IsOk());
    ++number_;
  }

  // The next frame set after the last step.
  FrameSet NextAfterStep() {
    FrameSet frame_set = frame_sets_->Next();
    while (frame_set.request_count < number_) {
      frame_set = frame_sets_->Next();
    }
    return frame_set;
  }

  static std::string RowOf(const std::vector<uint8_t>& observations, size_t row) {
    const auto begin =
        observations.begin() + static_cast<std::ptrdiff_t>(row * size_t{kObservationBytes});
    return {begin, begin + kObservationBytes};
  }

  TestPoolContext context_;
  const std::shared_ptr<WorkerPool> workers_ = std::make_shared<WorkerPool>(1);
  std::shared_ptr<PoolSession> session_;
  FramePublishers publishers_;
  const std::shared_ptr<FrameSets> frame_sets_ = std::make_shared<FrameSets>();
  int64_t number_ = 0;
  std::vector<uint8_t> observations_ = std::vector<uint8_t>(kWatchedCount * kObservationBytes);
  std::vector<uint8_t> final_observations_ = observations_;
};

TEST_F(FramePublisherTest, LastStateOfAnEpisodeIsShownOnceInPlaceOfTheCurrentOne) {
  Watch(kObservationSizePx);
  Step({7, kNoAction});
  Step({kEndEpisodeAction, kNoAction});
  FrameSet end = NextAfterStep();
  EXPECT_FALSE(end.ended_episodes[0].has_value());
  EXPECT_EQ(end.images[0], RowOf(observations_, 1));
  ASSERT_TRUE(end.ended_episodes[1].has_value());
  EXPECT_EQ(end.ended_episodes[1]->length, 2);
  EXPECT_EQ(end.images[1], RowOf(final_observations_, 0));
  EXPECT_THAT(end.steps, IsEmpty());

  const FrameSet start = frame_sets_->Next();
  EXPECT_EQ(start.request_count, 2);
  EXPECT_FALSE(start.ended_episodes[1].has_value());
  EXPECT_EQ(start.images[1], RowOf(observations_, 0));
}

TEST_F(FramePublisherTest, LastStateIsDrawnInHumanView) {
  Watch(100);
  Step({kEndEpisodeAction, kNoAction});
  const FrameSet end = NextAfterStep();
  const FrameSet start = frame_sets_->Next();
  EXPECT_TRUE(end.ended_episodes[1].has_value());
  EXPECT_FALSE(start.ended_episodes[1].has_value());
  EXPECT_EQ(end.images[0], start.images[0]);
  EXPECT_NE(end.images[1], start.images[1]);
}

// Otherwise a pool with short episodes would never show how they run.
TEST_F(FramePublisherTest, EveryEndIsFollowedByTheCurrentState) {
  Watch(kObservationSizePx);
  bool showed_end = false;
  int32_t end_count = 0;
  for (int32_t i = 0; i < 50; ++i) {
    Step({kEndEpisodeAction, kNoAction});
    const bool shows_end = frame_sets_->Next().ended_episodes[1].has_value();
    EXPECT_FALSE(showed_end && shows_end) << i;
    showed_end = shows_end;
    end_count += shows_end ? 1 : 0;
  }
  EXPECT_GT(end_count, 5);
}

TEST_F(FramePublisherTest, StepsBelongToTheirImages) {
  Watch(kObservationSizePx, /*with_steps=*/true);
  const std::vector<float> values = {1, 2, 3, std::numeric_limits<float>::infinity()};
  Step({7, 3}, {{"pair", values}});
  FrameSet frame_set = NextAfterStep();
  ASSERT_TRUE(frame_set.steps[0].has_value());
  EXPECT_EQ(frame_set.steps[0]->action, 3);
  EXPECT_EQ(frame_set.steps[0]->episode_length, 1);
  ASSERT_EQ(frame_set.steps[0]->annotations.size(), 1U);
  EXPECT_EQ(frame_set.steps[0]->annotations[0].name, "pair");
  EXPECT_THAT(frame_set.steps[0]->annotations[0].values,
              ElementsAre(3, std::numeric_limits<float>::infinity()));
  EXPECT_THAT(frame_set.steps[1]->annotations[0].values, ElementsAre(1, 2));

  Step({kEndEpisodeAction, kNoAction});
  frame_set = NextAfterStep();
  EXPECT_EQ(frame_set.steps[1]->action, kEndEpisodeAction);
  EXPECT_EQ(frame_set.steps[1]->episode_length, 2);
  EXPECT_THAT(frame_set.steps[1]->annotations, IsEmpty());
  frame_set = frame_sets_->Next();
  EXPECT_FALSE(frame_set.steps[1]->action.has_value());
  EXPECT_EQ(frame_set.steps[1]->episode_length, 0);
}

}  // namespace
}  // namespace procgen
