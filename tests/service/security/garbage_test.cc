// Invalid messages, and bytes that are not gRPC.

#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "absl/strings/str_cat.h"
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

TEST_F(GarbageTest, MethodsReportUnparsableMessages) {
  for (const char* method :
       {"PoolService/GetPool", "PoolService/ListPools", "PoolService/GetEpisode",
        "PoolService/WatchPool", "CatalogService/GetCatalog", "CatalogService/GetLoad",
        "ClusterService/ListNodes"}) {
    EXPECT_FALSE(CallRaw(channel_, absl::StrCat("/procgen.v1.", method), {kGarbage}).status.ok())
        << method;
  }
}

TEST_F(GarbageTest, StreamEndsAtTheFirstInvalidMessage) {
  EXPECT_THAT(CallRaw(channel_, kRunPoolPath, {kGarbage}).status,
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "the request's 13 bytes are not a valid procgen.v1.RunPoolRequest"));
}

TEST_F(GarbageTest, StreamAnswersRequestsBeforeAnInvalidMessage) {
  const RawResult result = CallRaw(channel_, kRunPoolPath,
                                   {StartRequest(MazeSpec(1)).SerializeAsString(),
                                    StepRequest({4}).SerializeAsString(), kGarbage});
  EXPECT_THAT(result.status,
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("not a valid")));
  ASSERT_EQ(result.responses.size(), 2U);
  v1::RunPoolResponse answer;
  ASSERT_TRUE(answer.ParseFromString(result.responses[1]));
  EXPECT_THAT(answer.batch().episode_lengths(), testing::ElementsAre(1));
}

TEST_F(GarbageTest, StreamEndsWithTheErrorOfItsFirstInvalidRequest) {
  v1::RunPoolRequest slow = SliceStepRequest(0, 100, 4);
  slow.mutable_step()->set_repeat_count(1000);  // the others arrive meanwhile
  EXPECT_THAT(CallRaw(channel_, kRunPoolPath,
                      {StartRequest(MazeSpec(100)).SerializeAsString(), slow.SerializeAsString(),
                       SliceStepRequest(0, 100, 99).SerializeAsString(), kGarbage})
                  .status,
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("actions[0] is 99")));
}

TEST_F(GarbageTest, UnknownMethodIsUnimplemented) {
  EXPECT_THAT(CallRaw(channel_, "/procgen.v1.PoolService/Nonsense", {""}).status,
              StatusIs(absl::StatusCode::kUnimplemented, testing::_));
}

TEST_F(GarbageTest, ConnectionThatSpeaksNoGrpcIsDropped) {
  const int connection = ConnectTo(server_->address());
  const std::string bytes(100000, 'x');
  send(connection, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  char answer[4096];
  ssize_t received = 0;
  do {
    received = recv(connection, answer, sizeof(answer), 0);
  } while (received > 0);
  close(connection);
}

TEST_F(GarbageTest, ReflectionListsTheServices) {
  // ServerReflectionRequest.list_services = 7, empty.
  const RawResult result =
      CallRaw(channel_, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
              {std::string("\x3a\x00", 2)});
  EXPECT_THAT(result.responses, Contains(HasSubstr(RunPoolService::service_full_name())));
}

}  // namespace
}  // namespace procgen
