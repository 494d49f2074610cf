// As broken_connection_test.cc, for longer.

#include "gtest/gtest.h"
#include "tests/service/broken_connection.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

class BrokenConnectionSlowTest : public ServiceTest {};

TEST_F(BrokenConnectionSlowTest, NothingIsLostInAThousandBreaks) {
  ExpectNothingIsLost(server_->address(), /*seed=*/1000, /*break_count=*/1000);
}

}  // namespace
}  // namespace procgen
