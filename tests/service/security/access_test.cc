// Authentication and authorization: tokens, owners and quotas.

#include <functional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "google/protobuf/descriptor.h"
#include "gtest/gtest.h"
#include "procgen/v1/catalog.grpc.pb.h"
#include "tests/service/raw_call.h"
#include "tests/service/security/access_fixture.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using procgen_client::Client;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class TokensTest : public AccessTest {
 protected:
  void SetUp() override {
    AccessTest::SetUp();
    Start({"--tokens=" + certificates_.Path("tokens"), "--owner_env_count_max=5"});
  }

  std::shared_ptr<grpc::Channel> Channel() const { return ChannelTo(address_); }
};

// The gRPC paths of all methods.
std::vector<std::string> AllMethods() {
  std::vector<std::string> methods;
  for (const google::protobuf::FileDescriptor* file :
       {v1::Catalog::descriptor()->file(), v1::Node::descriptor()->file(),
        v1::GetPoolRequest::descriptor()->file()}) {
    for (int i = 0; i < file->service_count(); ++i) {
      const google::protobuf::ServiceDescriptor* service = file->service(i);
      for (int j = 0; j < service->method_count(); ++j) {
        methods.push_back(absl::StrCat("/", service->full_name(), "/", service->method(j)->name()));
      }
    }
  }
  return methods;
}

TEST_F(TokensTest, EveryMethodRequiresATokenAndEchoesNone) {
  ASSERT_EQ(AllMethods().size(), 11U);
  for (const std::string& method : AllMethods()) {
    EXPECT_THAT(CallRaw(Channel(), method, {""}).status,
                StatusIs(absl::StatusCode::kUnauthenticated,
                         HasSubstr("has no token; expected: metadata 'authorization: Bearer")))
        << method;
    const absl::Status wrong = CallRaw(Channel(), method, {""}, "stranger-0123456789").status;
    EXPECT_THAT(wrong, StatusIs(absl::StatusCode::kUnauthenticated,
                                AllOf(HasSubstr("is not one of this server's"),
                                      Not(HasSubstr("stranger")))))
        << method;
    EXPECT_NE(CallRaw(Channel(), method, {""}, kAliceToken, 1).status.code(),
              absl::StatusCode::kUnauthenticated)
        << method;
  }
}

TEST_F(TokensTest, HealthAndReflectionNeedNoToken) {
  EXPECT_THAT(CallRaw(Channel(), "/grpc.health.v1.Health/Check", {""}).status, IsOk());
  EXPECT_THAT(CallRaw(Channel(), "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                      {std::string("\x3a\x00", 2)})
                  .status,
              IsOk());
}

TEST_F(TokensTest, TwoTokensAreRejected) {
  grpc::ClientContext context;
  context.AddMetadata("authorization", absl::StrCat("Bearer ", kAliceToken));
  context.AddMetadata("authorization", absl::StrCat("Bearer ", kBobToken));
  v1::Catalog catalog;
  EXPECT_EQ(v1::CatalogService::NewStub(Channel())
                ->GetCatalog(&context, v1::GetCatalogRequest(), &catalog)
                .error_code(),
            grpc::StatusCode::UNAUTHENTICATED);
}

// An operation on a pool that is identified by its name.
using PoolOperation = std::function<absl::Status(Client* client, const std::string& pool)>;

std::vector<std::pair<std::string, PoolOperation>> PoolOperations() {
  return {
      {"Get",
       [](Client* client, const std::string& pool) { return client->GetPool(pool).status(); }},
      {"Watch",
       [](Client* client, const std::string& pool) {
         v1::WatchPoolRequest request;
         request.set_pool(pool);
         request.add_environments(0);
         return client->Watch(request)->Next().status();
       }},
      {"GetEpisode", [](Client* client,
                        const std::string& pool) { return client->GetEpisode(pool, 0).status(); }},
  };
}

TEST_F(TokensTest, ForeignPoolsLookLikeMissingPools) {
  const auto alice = OpenStream(kAliceToken);
  const auto bob = OpenStream(kBobToken);
  ASSERT_THAT(alice->Start(MazeSpec(1), {}, "secret"), IsOk());
  EXPECT_EQ(alice->pool().owner(), "alice");
  ASSERT_THAT(bob->Start(MazeSpec(1), {}, "own"), IsOk());
  const auto client = ConnectAs(kBobToken);
  for (const auto& [name, operation] : PoolOperations()) {
    const absl::Status other = operation(client.get(), "pools/secret");
    const absl::Status none = operation(client.get(), "pools/nobody");
    EXPECT_EQ(other.code(), absl::StatusCode::kNotFound) << name << other;
    EXPECT_EQ(absl::StrReplaceAll(other.message(), {{"secret", "nobody"}}), none.message()) << name;
  }
  EXPECT_EQ(client->ListPools()->size(), 1U);
}

TEST_F(TokensTest, QuotasArePerOwner) {
  EXPECT_THAT(OpenStream(kAliceToken)->Start(MazeSpec(6)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 0 environments and asks for 6 more, limit "
                       "owner_env_count_max is 5"));
  const auto first = OpenStream(kAliceToken);
  const auto second = OpenStream(kAliceToken);
  ASSERT_THAT(first->Start(MazeSpec(2)), IsOk());
  ASSERT_THAT(second->Start(MazeSpec(3)), IsOk());
  EXPECT_THAT(OpenStream(kAliceToken)->Start(MazeSpec(1)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("owner alice has 5 environments and asks for 1 more")));
  EXPECT_THAT(OpenStream(kBobToken)->Start(MazeSpec(5)), IsOk());
  ASSERT_THAT(first->Close(), IsOk());
  EXPECT_THAT(OpenStream(kAliceToken)->Start(MazeSpec(2)), IsOk());
  EXPECT_EQ(ConnectAs(kAliceToken)->GetCatalog()->limits().owner_env_count_max(), 5);
}

TEST_F(TokensTest, TokensAreReplacedWhileAStreamRuns) {
  const auto run = OpenStream(kAliceToken);
  ASSERT_THAT(run->Start(MazeSpec(1)), IsOk());
  const std::string second = "alice-second-0123456789";
  certificates_.Replace("tokens", absl::StrCat("alice ", second, "\n"));
  EXPECT_THAT(ConnectAs(second)->GetPool(run->name()), IsOk());
  for (const char* token : {kAliceToken, kBobToken}) {
    EXPECT_THAT(ConnectAs(token)->GetCatalog(),
                StatusIs(absl::StatusCode::kUnauthenticated, testing::_));
  }
  v1::Batch batch;
  EXPECT_THAT(run->Step({4}, &batch), IsOk());

  certificates_.Replace("tokens", "alice");
  EXPECT_THAT(ConnectAs(second)->GetCatalog(), IsOk());
  EXPECT_THAT(run->Step({4}, &batch), IsOk());
  EXPECT_THAT(StopAndReadLog(),
              AllOf(HasSubstr("event=tokens_reloaded"), HasSubstr("event=tokens_reload_failed")));
}

TEST_F(TokensTest, NoTokenIsEverLogged) {
  const std::string wrong = "stranger-0123456789";
  const auto run = OpenStream(kAliceToken);
  ASSERT_THAT(run->Start(MazeSpec(1)), IsOk());
  EXPECT_FALSE(run->Call(StepRequest({99})).ok());
  EXPECT_FALSE(ConnectAs(wrong)->GetCatalog().ok());
  EXPECT_FALSE(OpenStream(wrong)->Start(MazeSpec(1)).ok());
  certificates_.Replace("tokens", absl::StrCat("bob ", kBobToken, "\n", kAliceToken));
  EXPECT_THAT(ConnectAs(kAliceToken)->GetCatalog(), IsOk());
  const std::string log = StopAndReadLog();
  EXPECT_THAT(log, HasSubstr("event=caller_refused"));
  EXPECT_THAT(log, HasSubstr("owner=alice"));
  for (const std::string& token : {std::string(kAliceToken), std::string(kBobToken), wrong}) {
    EXPECT_THAT(log, Not(HasSubstr(token)));
  }
}

}  // namespace
}  // namespace procgen
