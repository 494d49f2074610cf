// A learner on a faulty network receives what one on a good network receives.

#include "tests/service/robustness/broken_connection.h"

#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

class BrokenConnectionTest : public ServiceTest {};

TEST_F(BrokenConnectionTest, FiftyBreaksLoseNothing) {
  ExpectNothingIsLost(server_->address(), /*seed=*/7, /*break_count=*/50);
}

TEST_F(BrokenConnectionTest, BreaksLoseNoDeltas) {
  ExpectNothingIsLost(server_->address(), /*seed=*/8, /*break_count=*/40,
                      {.encoding = v1::ENCODING_DELTA_ZSTD});
}

}  // namespace
}  // namespace procgen
