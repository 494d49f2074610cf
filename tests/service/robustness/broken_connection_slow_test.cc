// As broken_connection_test.cc, with more faults and every transport.

#include "gtest/gtest.h"
#include "tests/service/robustness/broken_connection.h"
#include "tests/service/server_process.h"

namespace procgen {
namespace {

class BrokenConnectionSlowTest : public testing::TestWithParam<TransportCase> {};

TEST_P(BrokenConnectionSlowTest, ThousandBreaksLoseNothing) {
  ServerProcess server({"--address=127.0.0.1:0", "--workers=2", "--log_level=error"});
  ExpectNothingIsLost(server.Address(), /*seed=*/1000, /*break_count=*/1000, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Carriages, BrokenConnectionSlowTest, testing::ValuesIn(kTransportCases),
                         [](const testing::TestParamInfo<TransportCase>& transport_case) {
                           return v1::Transport_Name(transport_case.param.transport) + "_" +
                                  v1::Encoding_Name(transport_case.param.encoding) +
                                  (transport_case.param.pipe_transport ? "" : "_BY_GRPC");
                         });

}  // namespace
}  // namespace procgen
