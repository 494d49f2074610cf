// Owners share the server's background threads fairly.

#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "gmock/gmock.h"
#include "grpcpp/create_channel.h"
#include "gtest/gtest.h"
#include "procgen/v1/render.grpc.pb.h"
#include "procgen_client/client.h"
#include "server/rpc/server.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {
namespace {

constexpr char kAliceToken[] = "alice-token-0123456789";
constexpr char kBobToken[] = "bob-token-01234567890123";

std::unique_ptr<procgen_client::Client> ConnectAs(const std::string& token,
                                                  const std::string& address) {
  procgen_client::ConnectOptions options;
  options.credentials.emplace().token = token;
  auto client = procgen_client::Client::Connect(address, options);
  EXPECT_THAT(client, IsOk());
  return client.ok() ? *std::move(client) : nullptr;
}

// Sends kCount render requests of one owner at once and counts the responses.
class ManyRenderings {
 public:
  ManyRenderings(const std::shared_ptr<grpc::Channel>& channel, const std::string& token,
                 const std::string& pool)
      : stub_(v1::RenderService::NewStub(channel)) {
    request_.set_pool(pool);
    request_.set_format(v1::FRAME_FORMAT_PNG);
    request_.set_size_px(512);
    for (int i = 0; i < 4; ++i) {
      request_.add_environments(0);
    }
    for (Call& call : calls_) {
      call.context.AddMetadata("authorization", absl::StrCat("Bearer ", token));
      stub_->async()->RenderEnvironments(&call.context, &request_, &call.response,
                                         [this](const grpc::Status& status) {
                                           EXPECT_TRUE(status.ok()) << status.error_message();
                                           absl::MutexLock lock(&mutex_);
                                           ++answered_count_;
                                         });
    }
    AwaitAnswers(1);
  }
  ~ManyRenderings() { AwaitAnswers(kCount); }

  int answered_count() const {
    absl::MutexLock lock(&mutex_);
    return answered_count_;
  }

  static constexpr int kCount = 40;

 private:
  struct Call {
    grpc::ClientContext context;
    v1::RenderEnvironmentsResponse response;
  };
  void AwaitAnswers(int count) {
    const auto are_there = [this, count]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return answered_count_ >= count;
    };
    absl::MutexLock lock(&mutex_, absl::Condition(&are_there));
  }

  const std::unique_ptr<v1::RenderService::Stub> stub_;
  v1::RenderEnvironmentsRequest request_;
  std::vector<Call> calls_ = std::vector<Call>(kCount);
  mutable absl::Mutex mutex_;
  int answered_count_ ABSL_GUARDED_BY(mutex_) = 0;
};

TEST(FairnessTest, LongQueueOfOneOwnerDoesNotDelayOthers) {
  const TemporaryFolder folder;
  std::ofstream(folder.At("tokens")) << "alice " << kAliceToken << "\nbob " << kBobToken << "\n";
  auto tokens = TokenFile::Open(folder.At("tokens"));
  ASSERT_THAT(tokens, IsOk());
  ServerOptions options;
  options.address = "127.0.0.1:0";
  options.tokens = *std::move(tokens);
  const auto server = Server::Start(options);
  ASSERT_THAT(server, IsOk());
  const std::string& address = (*server)->address();
  const auto alice = ConnectAs(kAliceToken, address);
  const auto bob = ConnectAs(kBobToken, address);
  const auto pool = alice->CreatePool(MazeSpec(1));
  ASSERT_THAT(pool, IsOk());
  const ManyRenderings renderings(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()),
                                  kAliceToken, pool->name());
  const auto made = bob->CreatePool(MazeSpec(1));
  ASSERT_THAT(made, IsOk());
  EXPECT_THAT(bob->SaveStates(made->name()), IsOk());
  EXPECT_LT(renderings.answered_count(), ManyRenderings::kCount * 3 / 4);
}

}  // namespace
}  // namespace procgen
