// A learner whose connections break sees what one sees whose connection does not.

#include "tests/service/broken_connection.h"

#include "gtest/gtest.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

class BrokenConnectionTest : public ServiceTest {};

TEST_F(BrokenConnectionTest, NothingIsLostInFiftyBreaks) {
  ExpectNothingIsLost(server_->address(), /*seed=*/7, /*break_count=*/50);
}

}  // namespace
}  // namespace procgen
