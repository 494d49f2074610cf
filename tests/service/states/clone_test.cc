// Cloning between pools that clone from each other at the same time, and from other servers,
// including faulty ones.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "grpcpp/server_builder.h"
#include "gtest/gtest.h"
#include "httplib.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

std::vector<std::string> SnapshotsOf(procgen_client::Client* client, const std::string& pool) {
  std::vector<std::string> snapshots;
  const auto states = client->SaveStates(pool);
  EXPECT_THAT(states, IsOk());
  for (const v1::State& state : states.value_or(std::vector<v1::State>())) {
    snapshots.push_back(state.snapshot());
  }
  return snapshots;
}

class CloneTest : public ServiceTest {};

TEST_F(CloneTest, PoolsThatCloneFromEachOtherDoNotDeadlock) {
  const std::string one = CreatePool(MazeSpec(8));
  const std::string other = CreatePool(MazeSpec(8));
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      for (int round = 0; round < 25; ++round) {
        const bool forth = i % 2 == 0;
        EXPECT_THAT(client_->CloneStates(forth ? one : other, {Pair(i, 7 - i), Pair(1, 0)},
                                         {forth ? other : one, ""}),
                    IsOk());
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
}

TEST_F(CloneTest, AServerMayBeItsOwnSource) {
  const std::string name = CreatePool(MazeSpec(3));
  const std::vector<std::string> before = SnapshotsOf(client_.get(), name);
  ASSERT_THAT(client_->CloneStates(name, {Pair(0, 2)}, {"", server_->address()}), IsOk());
  EXPECT_EQ(SnapshotsOf(client_.get(), name)[2], before[0]);
}

TEST_F(CloneTest, LargeRemotePoolIsReadInPages) {
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.limits.response_bytes_max = 65536;
  const auto source = Server::Start(options);
  ASSERT_THAT(source, IsOk());
  const auto source_client = procgen_client::Client::Connect((*source)->address());
  ASSERT_THAT(source_client, IsOk());
  v1::PoolSpec spec = MazeSpec(300);
  spec.mutable_options()->set_rand_seed(99);
  const auto source_pool = (*source_client)->CreatePool(spec, "large");
  ASSERT_THAT(source_pool, IsOk());
  const std::vector<std::string> read = SnapshotsOf(source_client->get(), source_pool->name());
  const std::string target = CreatePool(MazeSpec(300));
  std::vector<v1::ClonePair> pairs;
  pairs.reserve(300);
  for (int32_t i = 0; i < 300; ++i) {
    pairs.push_back(Pair(299 - i, i));
  }
  ASSERT_THAT(client_->CloneStates(target, pairs, {source_pool->name(), (*source)->address()}),
              IsOk());
  EXPECT_EQ(SnapshotsOf(client_.get(), target),
            std::vector<std::string>(read.rbegin(), read.rend()));
}

TEST_F(CloneTest, SourceServerErrorsKeepTheirCodeAndNameTheServer) {
  const auto source = StartServer(/*worker_count=*/1);
  const std::string name = CreatePool(MazeSpec(1));
  EXPECT_THAT(client_->CloneStates(name, {Pair(0, 0)}, {"pools/none", source->address()}),
              StatusIs(absl::StatusCode::kNotFound,
                       "source_server " + source->address() + ": there is no pool pools/none"));
  const auto source_client = procgen_client::Client::Connect(source->address());
  ASSERT_THAT(source_client, IsOk());
  const auto source_pool = (*source_client)->CreatePool(MazeSpec(2), "two");
  ASSERT_THAT(source_pool, IsOk());
  EXPECT_THAT(client_->CloneStates(name, {Pair(2, 0)}, {"pools/two", source->address()}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "source_server " + source->address() +
                           ": environments[0] is 2, pool pools/two has environments 0 to 1"));
}

TEST_F(CloneTest, UnreachableSourceIsNamed) {
  const std::string name = CreatePool(MazeSpec(1));
  EXPECT_THAT(client_->CloneStates(name, {Pair(0, 0)}, {"", "127.0.0.1:1"}),
              StatusIs(absl::StatusCode::kUnavailable,
                       HasSubstr("source_server 127.0.0.1:1 cannot be reached within 30s")));
  EXPECT_THAT(client_->CloneStates(name, {Pair(0, 0)}, {"", std::string(513, 'x')}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       "source_server has 513 characters, allowed: at most 512"));
}

// A port without a listener and a listener that is no gRPC server give the same error.
TEST_F(CloneTest, SourcesThatAreNoServersGiveTheSameError) {
  const std::string name = CreatePool(MazeSpec(1));
  httplib::Server pages;
  const int port = pages.bind_to_any_port("127.0.0.1");
  std::thread serving([&pages] { pages.listen_after_bind(); });
  const auto error_of = [&](const std::string& source) {
    const absl::Status status = client_->CloneStates(name, {Pair(0, 0)}, {"", source});
    return std::pair(status.code(),
                     absl::StrReplaceAll(status.message(), {{source, "the source"}}));
  };
  const auto expected = error_of("127.0.0.1:1");
  EXPECT_EQ(expected.first, absl::StatusCode::kUnavailable);
  EXPECT_EQ(error_of(absl::StrCat("127.0.0.1:", port)), expected);
  EXPECT_EQ(error_of("unix:/dev/null"), expected);
  EXPECT_EQ(error_of("unix:/nowhere"), expected);
  pages.stop();
  serving.join();
}

// Accepts connections and sends nothing.
class SilentServer {
 public:
  SilentServer() : listening_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof(address);
    EXPECT_EQ(bind(listening_, reinterpret_cast<sockaddr*>(&address), length), 0);
    EXPECT_EQ(listen(listening_, 4), 0);
    EXPECT_EQ(getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &length), 0);
    address_ = absl::StrCat("127.0.0.1:", ntohs(address.sin_port));
  }
  ~SilentServer() {
    close(connection_);
    close(listening_);
  }

  const std::string& address() const { return address_; }
  // Waits for a connection.
  void Accept() { connection_ = accept(listening_, nullptr, nullptr); }

 private:
  const int listening_;
  int connection_ = -1;
  std::string address_;
};

class SilentSourceTest : public CloneTest {
 protected:
  void SetUp() override {
    CloneTest::SetUp();
    name_ = CreatePool(MazeSpec(1));
    request_.set_pool(name_);
    request_.set_source_server(silent_.address());
    *request_.add_pairs() = Pair(0, 0);
  }

  grpc::Status Clone(grpc::ClientContext* context) {
    v1::CloneStatesResponse response;
    return v1::StateService::NewStub(channel_)->CloneStates(context, request_, &response);
  }

  SilentServer silent_;
  std::string name_;
  v1::CloneStatesRequest request_;
};

TEST_F(SilentSourceTest, SilentSourceBlocksOnlyItsCallUntilTheDeadline) {
  std::thread caller([&] {
    grpc::ClientContext context;
    context.set_deadline(absl::ToChronoTime(absl::Now() + absl::Seconds(2)));
    EXPECT_THAT(Clone(&context).error_code(),
                testing::AnyOf(grpc::StatusCode::DEADLINE_EXCEEDED, grpc::StatusCode::UNAVAILABLE));
  });
  silent_.Accept();
  const auto stream = client_->Attach(name_);
  ASSERT_THAT(stream, IsOk());
  procgen_client::Batch batch;
  EXPECT_THAT((*stream)->Step({4}, &batch), IsOk());
  EXPECT_THAT(client_->CloneStates(name_, {Pair(0, 0)}), IsOk());
  caller.join();
}

TEST_F(SilentSourceTest, ShutdownDoesNotWaitForASource) {
  std::thread caller([&] {
    grpc::ClientContext context;
    EXPECT_FALSE(Clone(&context).ok());
  });
  silent_.Accept();
  server_is_alive_ = false;
  const absl::Time begin = absl::Now();
  server_->Stop(absl::ZeroDuration());
  EXPECT_LT(absl::Now() - begin, absl::Seconds(15));
  caller.join();
}

// A server that returns a response which does not match the request.
class WrongSource final : public v1::StateService::Service {
 public:
  explicit WrongSource(v1::SaveStatesResponse answer) : answer_(std::move(answer)) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(this);
    server_ = builder.BuildAndStart();
  }
  ~WrongSource() override { server_->Shutdown(); }

  std::string address() const { return absl::StrCat("127.0.0.1:", port_); }

  // Whether a request carried a token.
  bool saw_token() const { return saw_token_; }

  grpc::Status SaveStates(grpc::ServerContext* context, const v1::SaveStatesRequest* /*request*/,
                          v1::SaveStatesResponse* response) override {
    saw_token_ = context->client_metadata().contains("authorization");
    *response = answer_;
    return grpc::Status::OK;
  }

 private:
  const v1::SaveStatesResponse answer_;
  std::atomic<bool> saw_token_ = false;
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

TEST_F(CloneTest, CallersTokenIsNotForwarded) {
  const WrongSource source({});
  v1::CloneStatesRequest request;
  request.set_pool(CreatePool(MazeSpec(1)));
  request.set_source_server(source.address());
  *request.add_pairs() = Pair(0, 0);
  grpc::ClientContext context;
  context.AddMetadata("authorization", "Bearer 0123456789abcdef");
  v1::CloneStatesResponse response;
  EXPECT_EQ(
      v1::StateService::NewStub(channel_)->CloneStates(&context, request, &response).error_code(),
      grpc::StatusCode::INTERNAL)
      << "the source returned an empty response";
  EXPECT_FALSE(source.saw_token());
}

TEST_F(CloneTest, UnrequestedResponsesAreRejected) {
  const std::string name = CreatePool(MazeSpec(2));
  v1::SaveStatesResponse none;
  v1::SaveStatesResponse none_for_ever;
  none_for_ever.set_next_page_token("more");
  v1::SaveStatesResponse another;
  another.add_states()->set_environment(1);
  v1::SaveStatesResponse too_many;
  too_many.add_states()->set_environment(0);
  too_many.add_states()->set_environment(1);
  v1::SaveStatesResponse one_for_ever;
  one_for_ever.add_states()->set_environment(0);
  one_for_ever.set_next_page_token("more");
  for (const v1::SaveStatesResponse& answer :
       {none, none_for_ever, another, too_many, one_for_ever}) {
    const WrongSource source(answer);
    EXPECT_THAT(client_->CloneStates(name, {Pair(0, 1)}, {"", source.address()}),
                StatusIs(absl::StatusCode::kInternal, "source_server " + source.address() +
                                                          " returned other environments of pool " +
                                                          name + " than requested"));
  }
  v1::SaveStatesResponse no_snapshot;
  no_snapshot.add_states()->set_environment(0);
  const WrongSource source(no_snapshot);
  EXPECT_THAT(client_->CloneStates(name, {Pair(0, 1)}, {"", source.address()}),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr("environment 1: ")));
}

}  // namespace
}  // namespace procgen
