// Authentication and authorization: tokens, owners and quotas.

#include <functional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "dm_env_rpc/v1/dm_env_rpc.pb.h"
#include "gmock/gmock.h"
#include "google/protobuf/descriptor.h"
#include "grpcpp/create_channel.h"
#include "gtest/gtest.h"
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
    Start({"--tokens=" + certificates_.Path("tokens"), "--owner_pool_count_max=2",
           "--owner_env_count_max=5", "--owner_stream_count_max=1"});
  }

  std::shared_ptr<grpc::Channel> Channel() const {
    return grpc::CreateChannel(address_, grpc::InsecureChannelCredentials());
  }
};

// The gRPC paths of all methods.
std::vector<std::string> AllMethods() {
  std::vector<std::string> methods;
  for (const google::protobuf::FileDescriptor* file :
       {v1::Catalog::descriptor()->file(), v1::Node::descriptor()->file(),
        v1::Pool::descriptor()->file(), v1::Attach::descriptor()->file(),
        v1::State::descriptor()->file(), v1::Frame::descriptor()->file(),
        dm_env_rpc::v1::Tensor::descriptor()->file()}) {
    const google::protobuf::ServiceDescriptor* service = file->service(0);
    for (int i = 0; i < service->method_count(); ++i) {
      methods.push_back(absl::StrCat("/", service->full_name(), "/", service->method(i)->name()));
    }
  }
  return methods;
}

TEST_F(TokensTest, EveryMethodRequiresATokenAndEchoesNone) {
  ASSERT_GE(AllMethods().size(), 16U);
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

std::vector<std::pair<std::string, PoolOperation>> PoolOperations(const std::string& own_pool) {
  return {
      {"Get",
       [](Client* client, const std::string& pool) { return client->GetPool(pool).status(); }},
      {"Attach",
       [](Client* client, const std::string& pool) { return client->Attach(pool).status(); }},
      {"TakeOver",
       [](Client* client, const std::string& pool) {
         return client->Attach(pool, {.take_over = true}).status();
       }},
      {"Renew",
       [](Client* client, const std::string& pool) { return client->RenewPool(pool).status(); }},
      {"Save",
       [](Client* client, const std::string& pool) { return client->SaveStates(pool).status(); }},
      {"Restore",
       [](Client* client, const std::string& pool) {
         return client->RestoreStates(pool, std::vector<v1::State>(1));
       }},
      {"CloneWithin",
       [](Client* client, const std::string& pool) {
         return client->CloneStates(pool, {Pair(0, 0)});
       }},
      {"CloneInto",
       [own_pool](Client* client, const std::string& pool) {
         return client->CloneStates(pool, {Pair(0, 0)}, {own_pool, ""});
       }},
      {"CloneFrom",
       [own_pool](Client* client, const std::string& pool) {
         return client->CloneStates(own_pool, {Pair(0, 0)}, {pool, ""});
       }},
      {"Render",
       [](Client* client, const std::string& pool) {
         return client->RenderEnvironments(pool, {0}).status();
       }},
      {"Watch",
       [](Client* client, const std::string& pool) {
         v1::WatchPoolRequest request;
         request.set_pool(pool);
         request.add_environments(0);
         return client->Watch(request)->Next().status();
       }},
      {"GetEpisode", [](Client* client,
                        const std::string& pool) { return client->GetEpisode(pool, 0).status(); }},
      {"Delete", [](Client* client, const std::string& pool) { return client->DeletePool(pool); }},
  };
}

TEST_F(TokensTest, ForeignPoolsLookLikeMissingPools) {
  const auto alice = ConnectAs(kAliceToken);
  const auto bob = ConnectAs(kBobToken);
  const auto secret = alice->CreatePool(MazeSpec(1), "secret");
  ASSERT_THAT(secret, IsOk());
  EXPECT_EQ(secret->owner(), "alice");
  ASSERT_THAT(bob->CreatePool(MazeSpec(1), "own"), IsOk());
  for (const auto& [name, operation] : PoolOperations("pools/own")) {
    const absl::Status other = operation(bob.get(), "pools/secret");
    const absl::Status none = operation(bob.get(), "pools/nobody");
    EXPECT_EQ(other.code(), absl::StatusCode::kNotFound) << name << other;
    EXPECT_EQ(absl::StrReplaceAll(other.message(), {{"secret", "nobody"}}), none.message()) << name;
  }
  EXPECT_THAT(alice->GetPool("pools/secret"), IsOk()) << "the pool still exists";
  EXPECT_EQ(bob->ListPools()->size(), 1U);
}

TEST_F(TokensTest, OwnersMayUseTheSameNames) {
  const auto alice = ConnectAs(kAliceToken);
  const auto bob = ConnectAs(kBobToken);
  ASSERT_THAT(alice->CreatePool(MazeSpec(1), "maze"), IsOk());
  ASSERT_THAT(bob->CreatePool(MazeSpec(2), "maze"), IsOk());
  EXPECT_EQ(alice->GetPool("pools/maze")->spec().env_count(), 1);
  EXPECT_EQ(bob->GetPool("pools/maze")->spec().env_count(), 2);
}

TEST_F(TokensTest, QuotasArePerOwner) {
  const auto alice = ConnectAs(kAliceToken);
  const auto bob = ConnectAs(kBobToken);
  EXPECT_THAT(alice->CreatePool(MazeSpec(6)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 0 environments and asks for 6 more, limit "
                       "owner_env_count_max is 5"));
  const auto first = alice->CreatePool(MazeSpec(1));
  const auto second = alice->CreatePool(MazeSpec(1));
  ASSERT_THAT(first, IsOk());
  ASSERT_THAT(second, IsOk());
  EXPECT_THAT(alice->CreatePool(MazeSpec(1)),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       testing::HasSubstr("owner alice has 2 pools and asks for 1 more, limit "
                                          "owner_pool_count_max is 2; 2 of 2 own pools")));
  auto stream = alice->Attach(first->name());
  ASSERT_THAT(stream, IsOk());
  EXPECT_THAT(alice->Attach(second->name()),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       "owner alice has 1 streams and asks for 1 more, limit "
                       "owner_stream_count_max is 1"));
  EXPECT_THAT(bob->CreatePool(MazeSpec(5)), IsOk());
  ASSERT_THAT((*stream)->Close(), IsOk());
  EXPECT_THAT(alice->Attach(second->name()), IsOk());
  const v1::Limits limits = alice->GetCatalog()->limits();
  EXPECT_EQ(limits.owner_pool_count_max(), 2);
  EXPECT_EQ(limits.owner_env_count_max(), 5);
  EXPECT_EQ(limits.owner_stream_count_max(), 1);
}

TEST_F(TokensTest, TokensAreReplacedWhileAStreamRuns) {
  const auto alice = ConnectAs(kAliceToken);
  const auto pool = alice->CreatePool(MazeSpec(1));
  ASSERT_THAT(pool, IsOk());
  const auto stream = alice->Attach(pool->name());
  ASSERT_THAT(stream, IsOk());
  const std::string second = "alice-second-0123456789";
  certificates_.Replace("tokens", absl::StrCat("alice ", second, "\n"));
  EXPECT_THAT(ConnectAs(second)->GetPool(pool->name()), IsOk());
  EXPECT_THAT(alice->GetPool(pool->name()),
              StatusIs(absl::StatusCode::kUnauthenticated, testing::_));
  EXPECT_THAT(ConnectAs(kBobToken)->GetCatalog(),
              StatusIs(absl::StatusCode::kUnauthenticated, testing::_));
  procgen_client::Batch batch;
  EXPECT_THAT((*stream)->Step({4}, &batch), IsOk());

  certificates_.Replace("tokens", "alice");
  EXPECT_THAT(ConnectAs(second)->GetCatalog(), IsOk());
  EXPECT_THAT((*stream)->Step({4}, &batch), IsOk());
  EXPECT_THAT(StopAndReadLog(),
              AllOf(HasSubstr("event=tokens_reloaded"), HasSubstr("event=tokens_reload_failed")));
}

TEST_F(TokensTest, NoTokenIsEverLogged) {
  const std::string wrong = "stranger-0123456789";
  const auto alice = ConnectAs(kAliceToken);
  const auto pool = alice->CreatePool(MazeSpec(1));
  ASSERT_THAT(pool, IsOk());
  {
    const auto stream = alice->Attach(pool->name());
    procgen_client::Batch batch;
    ASSERT_THAT((*stream)->Step({4}, &batch), IsOk());
    EXPECT_FALSE((*stream)->Step({99}, &batch).ok());
  }
  EXPECT_FALSE(ConnectAs(wrong)->GetCatalog().ok());
  EXPECT_FALSE(ConnectAs(wrong)->Attach(pool->name()).ok());
  certificates_.Replace("tokens", absl::StrCat("bob ", kBobToken, "\n", kAliceToken));
  EXPECT_THAT(alice->DeletePool(pool->name()), IsOk());
  const std::string log = StopAndReadLog();
  EXPECT_THAT(log, HasSubstr("event=caller_refused"));
  EXPECT_THAT(log, HasSubstr("owner=alice"));
  for (const std::string& token : {std::string(kAliceToken), std::string(kBobToken), wrong}) {
    EXPECT_THAT(log, Not(HasSubstr(token)));
  }
}

}  // namespace
}  // namespace procgen
