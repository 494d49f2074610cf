// Invalid messages, and bytes that are not gRPC.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "absl/strings/numbers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/service/raw_call.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::Contains;
using testing::HasSubstr;

// Field 1 with a length beyond the end of the message.
const char kGarbage[] = "\x0a\xff\xff\xff\x7f garbage";

class GarbageTest : public ServiceTest {};

TEST_F(GarbageTest, UnaryMethodsReportUnparsableMessages) {
  for (const auto& [method, message] :
       {std::pair<std::string, std::string>{"/procgen.v1.PoolService/CreatePool",
                                            "procgen.v1.CreatePoolRequest"},
        {"/procgen.v1.PoolService/GetPool", "procgen.v1.GetPoolRequest"},
        {"/procgen.v1.PoolService/ListPools", "procgen.v1.ListPoolsRequest"},
        {"/procgen.v1.PoolService/DeletePool", "procgen.v1.DeletePoolRequest"},
        {"/procgen.v1.PoolService/RenewPool", "procgen.v1.RenewPoolRequest"},
        {"/procgen.v1.CatalogService/GetCatalog", "procgen.v1.GetCatalogRequest"},
        {"/procgen.v1.CatalogService/GetLoad", "procgen.v1.GetLoadRequest"},
        {"/procgen.v1.ClusterService/ListNodes", "procgen.v1.ListNodesRequest"},
        {"/procgen.v1.ClusterService/WatchNodes", "procgen.v1.WatchNodesRequest"},
        {"/procgen.v1.StateService/SaveStates", "procgen.v1.SaveStatesRequest"},
        {"/procgen.v1.StateService/RestoreStates", "procgen.v1.RestoreStatesRequest"},
        {"/procgen.v1.StateService/CloneStates", "procgen.v1.CloneStatesRequest"},
        {"/procgen.v1.StateService/GetEpisode", "procgen.v1.GetEpisodeRequest"},
        {"/procgen.v1.RenderService/RenderEnvironments", "procgen.v1.RenderEnvironmentsRequest"},
        {"/procgen.v1.RenderService/WatchPool", "procgen.v1.WatchPoolRequest"}}) {
    EXPECT_THAT(CallRaw(channel_, method, {kGarbage}).status,
                StatusIs(absl::StatusCode::kInvalidArgument,
                         "the request's 13 bytes are not a valid " + message));
  }
}

TEST_F(GarbageTest, StreamEndsAtTheFirstInvalidMessage) {
  EXPECT_THAT(CallRaw(channel_, "/procgen.v1.StepService/StepPool", {kGarbage}).status,
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "the request's 13 bytes are not a valid procgen.v1.StepPoolRequest"));
}

TEST_F(GarbageTest, StreamAnswersRequestsBeforeAnInvalidMessage) {
  v1::StepPoolRequest attach;
  attach.mutable_attach()->set_pool(CreatePool(MazeSpec(1)));
  v1::StepPoolRequest step = StepRequest({4});
  step.set_sequence_number(1);
  const RawResult result =
      CallRaw(channel_, "/procgen.v1.StepService/StepPool",
              {attach.SerializeAsString(), step.SerializeAsString(), kGarbage});
  EXPECT_THAT(result.status,
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("not a valid")));
  ASSERT_EQ(result.responses.size(), 2U);
  v1::StepPoolResponse answer;
  ASSERT_TRUE(answer.ParseFromString(result.responses[1]));
  EXPECT_EQ(answer.sequence_number(), 1);
}

TEST_F(GarbageTest, UnknownMethodIsUnimplemented) {
  EXPECT_THAT(CallRaw(channel_, "/procgen.v1.PoolService/Nonsense", {""}).status,
              StatusIs(absl::StatusCode::kUnimplemented, testing::_));
}

TEST_F(GarbageTest, ConnectionThatSpeaksNoGrpcIsDropped) {
  int port = 0;
  ASSERT_TRUE(
      absl::SimpleAtoi(server_->address().substr(server_->address().rfind(':') + 1), &port));
  const int connection = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(connect(connection, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  const std::string bytes(100000, 'x');
  send(connection, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  char answer[4096];
  ssize_t received = 0;
  do {
    received = recv(connection, answer, sizeof(answer), 0);
  } while (received > 0);
  close(connection);
}

TEST_F(GarbageTest, HealthReportsServing) {
  // HealthCheckRequest and HealthCheckResponse have one field each: service, status.
  const RawResult whole = CallRaw(channel_, "/grpc.health.v1.Health/Check", {""});
  EXPECT_THAT(whole.responses, testing::ElementsAre("\x08\x01"));
  const std::string service = "procgen.v1.StepService";
  const RawResult one =
      CallRaw(channel_, "/grpc.health.v1.Health/Check",
              {"\x0a" + std::string(1, static_cast<char>(service.size())) + service});
  EXPECT_THAT(one.responses, testing::ElementsAre("\x08\x01"));
}

TEST_F(GarbageTest, ReflectionListsTheServices) {
  // ServerReflectionRequest.list_services = 7, empty.
  const RawResult result =
      CallRaw(channel_, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
              {std::string("\x3a\x00", 2)});
  EXPECT_THAT(result.responses, Contains(HasSubstr("procgen.v1.StepService")));
}

}  // namespace
}  // namespace procgen
