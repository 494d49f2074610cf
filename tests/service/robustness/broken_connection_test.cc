// A learner on a faulty network receives what one on a good network receives.

#include "tests/service/robustness/broken_connection.h"

#include "gtest/gtest.h"
#include "tests/service/server_process.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

class BrokenConnectionTest : public ServiceTest {};

TEST_F(BrokenConnectionTest, FiftyBreaksLoseNothing) {
  ExpectNothingIsLost(server_->address(), /*seed=*/7, /*break_count=*/50);
}

TEST_F(BrokenConnectionTest, BreaksLoseNoDeltas) {
  ExpectNothingIsLost(server_->address(), /*seed=*/8, /*break_count=*/40, v1::ENCODING_DELTA_ZSTD);
}

TEST(BrokenConnectionSlowTest, TwoThousandBreaksLoseNothing) {
  ServerProcess server({"--address=127.0.0.1:0", "--workers=2", "--log_level=error"});
  const std::string address = server.Address();
  for (const v1::Encoding encoding : {v1::ENCODING_RAW, v1::ENCODING_DELTA_ZSTD}) {
    ExpectNothingIsLost(address, /*seed=*/1000, /*break_count=*/1000, encoding);
  }
}

}  // namespace
}  // namespace procgen
