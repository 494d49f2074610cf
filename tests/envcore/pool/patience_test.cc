#include "envcore/pool/patience.h"

#include <chrono>
#include <thread>

#include "gtest/gtest.h"

namespace procgen {
namespace {

// How often it looks for what does not come.
int LooksInVain(Patience& patience) {
  int looks = 0;
  patience.Await([&looks] {
    ++looks;
    return false;
  });
  return looks;
}

TEST(PatienceTest, LooksForAMomentUntilItIsReady) {
  Patience patience;
  int looks = 0;
  patience.Await([&looks] { return ++looks == 3; });
  EXPECT_EQ(looks, 3);
}

TEST(PatienceTest, AfterALongWaitItGoesToSleepAtOnce) {
  Patience patience;
  EXPECT_EQ(LooksInVain(patience), kLooksBeforeSleep);
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  patience.EndWait();
  EXPECT_EQ(LooksInVain(patience), 0);
}

TEST(PatienceTest, AfterAShortWaitItLooksAgain) {
  Patience patience;
  LooksInVain(patience);
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  patience.EndWait();
  // A wait that should be short may be interrupted by another program.
  int looks = 0;
  for (int tries = 0; tries < 1000 && looks == 0; ++tries) {
    looks = LooksInVain(patience);
    patience.EndWait();
  }
  EXPECT_EQ(looks, kLooksBeforeSleep);
}

}  // namespace
}  // namespace procgen
