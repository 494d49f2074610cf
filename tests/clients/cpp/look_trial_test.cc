#include "procgen_client/look_trial.h"

#include "absl/time/time.h"
#include "gtest/gtest.h"

namespace procgen_client {
namespace {

// Answers that take so long, one after the other.
class Answers {
 public:
  Answers(absl::Duration sleeping, absl::Duration looking)
      : sleeping_(sleeping), looking_(looking) {}

  void Come(LookTrial* trial, int count) {
    for (int i = 0; i < count; ++i) {
      now_ += trial->looks() ? looking_ : sleeping_;
      trial->OnAnswer([this] { return now_; });
    }
  }

 private:
  const absl::Duration sleeping_;
  const absl::Duration looking_;
  absl::Time now_ = absl::UnixEpoch();
};

// Until it has decided: some answers are not counted, then both ways are tried.
constexpr int kUndecidedAnswers = 3 * LookTrial::kTriedAnswers;

TEST(LookTrialTest, BothWaysAreTriedAndTheFasterIsTaken) {
  LookTrial trial;
  Answers answers(absl::Microseconds(100), absl::Microseconds(80));
  answers.Come(&trial, 2 * LookTrial::kTriedAnswers - 1);
  EXPECT_FALSE(trial.looks());
  answers.Come(&trial, 1);
  EXPECT_TRUE(trial.looks()) << "it is tried";
  answers.Come(&trial, LookTrial::kTriedAnswers + LookTrial::kDecidedAnswers - 1);
  EXPECT_TRUE(trial.looks()) << "it has won";
}

TEST(LookTrialTest, WhoGainsLittleSleeps) {
  LookTrial trial;
  Answers answers(absl::Microseconds(100), absl::Microseconds(98));
  answers.Come(&trial, kUndecidedAnswers);
  EXPECT_FALSE(trial.looks());
}

TEST(LookTrialTest, TheOtherWayIsTriedAgain) {
  LookTrial trial;
  Answers(absl::Microseconds(100), absl::Microseconds(80)).Come(&trial, kUndecidedAnswers);
  EXPECT_TRUE(trial.looks());
  Answers harmed(absl::Microseconds(100), absl::Microseconds(200));
  harmed.Come(&trial, LookTrial::kDecidedAnswers + 2 * LookTrial::kTriedAnswers);
  EXPECT_FALSE(trial.looks());
  harmed.Come(&trial, LookTrial::kDecidedAnswers - 1);
  EXPECT_FALSE(trial.looks());
}

}  // namespace
}  // namespace procgen_client
