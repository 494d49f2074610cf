#ifndef TESTS_SERVICE_STREAM_SHARED_MEMORY_FIXTURE_H_
#define TESTS_SERVICE_STREAM_SHARED_MEMORY_FIXTURE_H_

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "procgen_client/internal/grpc_error.h"
#include "server/rpc/server.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"
#include "tests/temporary_folder.h"

namespace procgen {

inline v1::PoolSpec SharedSpec(v1::PoolSpec spec) {
  spec.set_transport(v1::TRANSPORT_SHARED_MEMORY);
  return spec;
}

// A server with its own shared memory folder. Expects after each test that the folder is empty.
class SharedMemoryTest : public testing::Test {
 protected:
  std::unique_ptr<Server> StartServer(const Limits& limits = {},
                                      const std::string& address = "127.0.0.1:0") {
    ServerOptions options;
    options.address = address;
    options.worker_count = 3;
    options.limits = limits;
    options.shared_memory_dir = *SharedMemoryDir::Open(folder_.path());
    absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
    EXPECT_THAT(server, IsOk());
    return *std::move(server);
  }

  void SetUp() override { Use(StartServer()); }

  void Use(std::unique_ptr<Server> server) {
    client_ = nullptr;
    server_ = std::move(server);
    client_ = *procgen_client::Client::Connect(server_->address());
  }

  void TearDown() override {
    client_ = nullptr;
    server_ = nullptr;
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
  }

  std::string CreatePool(const v1::PoolSpec& spec) {
    const auto pool = client_->CreatePool(spec);
    EXPECT_THAT(pool, IsOk());
    return pool.ok() ? pool->name() : "";
  }

  std::unique_ptr<procgen_client::StepStream> Attach(
      const std::string& pool, const procgen_client::StreamOptions& options = {}) {
    auto stream = client_->Attach(pool, options);
    EXPECT_THAT(stream, IsOk());
    return stream.ok() ? *std::move(stream) : nullptr;
  }

  // The status of a raw stream that attaches with `held` and sends `request`.
  absl::Status StatusOfRaw(const std::string& pool, const std::vector<int32_t>& held,
                           v1::StepPoolRequest request) {
    const auto stub = v1::StepService::NewStub(
        grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials()));
    grpc::ClientContext context;
    const auto stream = stub->StepPool(&context);
    v1::StepPoolRequest attach;
    attach.mutable_attach()->set_pool(pool);
    attach.mutable_attach()->mutable_held_batches()->Assign(held.begin(), held.end());
    stream->Write(attach);
    v1::StepPoolResponse response;
    if (stream->Read(&response)) {
      request.set_sequence_number(response.attached().next_sequence_number());
      stream->Write(request);
      stream->WritesDone();
      while (stream->Read(&response)) {
      }
    }
    return procgen_client::ToAbslStatus(stream->Finish());
  }

  const TemporaryFolder folder_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<procgen_client::Client> client_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_STREAM_SHARED_MEMORY_FIXTURE_H_
