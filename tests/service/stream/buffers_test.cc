// The server's buffers per owner are bounded, and freed memory returns to the system.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "gtest/gtest.h"
#include "procgen/v1/render.grpc.pb.h"
#include "server/concurrency/steady_time.h"
#include "tests/service/robustness/process_resources.h"
#include "tests/service/service_fixture.h"

namespace procgen {
namespace {

using testing::HasSubstr;

constexpr int64_t kBufferBytesMax = 26 << 20;
constexpr char kLimit[] = "limit owner_buffer_bytes_max is 27262976";
constexpr absl::Duration kTimeout = absl::Seconds(30);

// Repeats `attempt` until it returns true or the timeout passes.
template <typename Try>
bool Eventually(Try attempt) {
  for (const absl::Time end = SteadyNow() + kTimeout; SteadyNow() < end;) {
    if (attempt()) {
      return true;
    }
    absl::SleepFor(absl::Milliseconds(20));
  }
  return attempt();
}

// A second server, with a small limit on buffers per owner.
class BuffersTest : public ServiceTest {
 protected:
  void SetUp() override {
    ServiceTest::SetUp();
    ServerOptions options;
    options.address = "127.0.0.1:0";
    options.worker_count = 2;
    options.limits = TestLimits();
    options.limits.request_bytes_max = 4 << 20;
    options.limits.owner_buffer_bytes_max = kBufferBytesMax;
    absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
    ASSERT_THAT(server, IsOk());
    small_ = *std::move(server);
    auto client =
        procgen_client::Client::Connect(small_->address(), {.response_bytes_max = 16 << 20});
    ASSERT_THAT(client, IsOk());
    client_ = *std::move(client);
  }

  std::unique_ptr<Server> small_;
};

// A level sampler that takes `count` * 16 bytes in a pool.
v1::LevelSampler SamplerOf(int32_t count) {
  v1::LevelSampler sampler;
  for (int32_t i = 0; i < count; ++i) {
    sampler.add_level_seeds(i);
    sampler.add_weights(1);
  }
  return sampler;
}

// A channel that accepts large responses.
std::shared_ptr<grpc::Channel> LargeChannel(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(16 << 20);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

// A request with a response of 12 MiB.
v1::RenderEnvironmentsRequest LargeRender(const std::string& pool) {
  v1::RenderEnvironmentsRequest request;
  request.set_pool(pool);
  request.set_size_px(1024);
  request.set_response_bytes_max(16 << 20);
  for (int i = 0; i < 4; ++i) {
    request.add_environments(0);
  }
  return request;
}

// A big-endian integer, as in HTTP/2.
std::string BigEndian(size_t number, int bytes) {
  std::string encoded;
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) {
    encoded += static_cast<char>(number >> shift & 0xff);
  }
  return encoded;
}

// A raw connection with a flow control window of zero, so it receives no response bytes.
class NonReadingConnection {
 public:
  explicit NonReadingConnection(const std::string& address) {
    sockaddr_in peer = {};
    peer.sin_family = AF_INET;
    peer.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    peer.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&peer), sizeof(peer)), 0);
    constexpr int kInitialWindowSize = 4;
    Write("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" +
          Frame(kSettings, 0, 0, BigEndian(kInitialWindowSize, 2) + BigEndian(0, 4)));
  }
  ~NonReadingConnection() { close(socket_); }
  NonReadingConnection(const NonReadingConnection&) = delete;
  NonReadingConnection& operator=(const NonReadingConnection&) = delete;

  void Call(const std::string& method, const std::string& message) {
    std::string headers;
    for (const auto& [name, value] : {std::pair<std::string, std::string>(":method", "POST"),
                                      {":scheme", "http"},
                                      {":path", method},
                                      {":authority", "test"},
                                      {"te", "trailers"},
                                      {"content-type", "application/grpc"}}) {
      headers += BigEndian(0, 1) + BigEndian(name.size(), 1) + name;
      headers += BigEndian(value.size(), 1) + value;
    }
    const std::string data = BigEndian(0, 1) + BigEndian(message.size(), 4) + message;
    constexpr int kEndHeaders = 4;
    constexpr int kEndStream = 1;
    Write(Frame(kHeaders, kEndHeaders, stream_, headers) + Frame(kData, kEndStream, stream_, data));
    stream_ += 2;
  }

 private:
  static constexpr int kData = 0;
  static constexpr int kHeaders = 1;
  static constexpr int kSettings = 4;

  static std::string Frame(int type, int flags, size_t stream, const std::string& payload) {
    return BigEndian(payload.size(), 3) + static_cast<char>(type) + static_cast<char>(flags) +
           BigEndian(stream, 4) + payload;
  }
  void Write(const std::string& bytes) const {
    EXPECT_EQ(write(socket_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }

  const int socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  size_t stream_ = 1;
};

TEST_F(BuffersTest, UnreadResponsesPerOwnerAreBounded) {
  const std::string pool = CreatePool(MazeSpec(1));
  auto unread = std::make_unique<NonReadingConnection>(small_->address());
  // Two responses fit the limit; a third one is rejected, from any connection.
  const auto render = [&] {
    // A new connection per call: open connections keep receive buffers of several MiB.
    const auto reader = v1::RenderService::NewStub(LargeChannel(small_->address()));
    grpc::ClientContext context;
    v1::RenderEnvironmentsResponse response;
    return reader->RenderEnvironments(&context, LargeRender(pool), &response);
  };
  ASSERT_TRUE(render().ok());  // allocates the renderer's caches before the measurement
  const int64_t before = AllocatedBytes();
  grpc::Status status;
  EXPECT_TRUE(Eventually([&] {
    unread->Call("/procgen.v1.RenderService/RenderEnvironments",
                 LargeRender(pool).SerializeAsString());
    status = render();
    return !status.ok();
  }));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr(kLimit));
  // After the pending calls, the server keeps no message in addition to its serialized form.
  EXPECT_TRUE(Eventually([&] { return AllocatedBytes() - before < kBufferBytesMax + (14 << 20); }))
      << AllocatedBytes() - before;
  unread = nullptr;
  EXPECT_TRUE(Eventually([&] { return render().ok(); }))
      << "responses of a lost connection are freed";
}

TEST_F(BuffersTest, LevelSamplersCountUntilTheirPoolsAreDeleted) {
  v1::PoolSpec spec = MazeSpec(1);
  *spec.mutable_level_sampler() = SamplerOf(500'000);  // 8 MB
  const std::string first = CreatePool(spec);
  CreatePool(spec);
  EXPECT_THAT(client_->CreatePool(spec),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr(kLimit)));
  EXPECT_THAT(client_->CreatePool(MazeSpec(1)), IsOk()) << "the other owner needs none";
  ASSERT_THAT(client_->DeletePool(first), IsOk());
  EXPECT_TRUE(Eventually([&] { return client_->CreatePool(spec).ok(); }));
}

TEST_F(BuffersTest, ReplacedSamplerIsNotCounted) {
  const auto stream = CreateAndAttach(MazeSpec(2));
  procgen_client::Batch batch;
  v1::StepPoolRequest request;
  *request.mutable_level_sampler() = SamplerOf(200'000);  // 3 MB
  for (int i = 0; i < 20; ++i) {
    ASSERT_THAT(stream->Call(request, &batch), IsOk()) << i;
    ASSERT_THAT(stream->Step({4, 4}, &batch), IsOk());
  }
}

// A request with `count` unknown fields, of 2 bytes each on the wire and 16 or more in memory.
v1::StepPoolRequest UnknownFields(int32_t count) {
  v1::StepPoolRequest request;
  request.mutable_observe();
  std::string unknown;
  for (int32_t i = 0; i < count; ++i) {
    unknown += "\x78\x01";
  }
  EXPECT_TRUE(request.MergeFromString(unknown));
  return request;
}

TEST_F(BuffersTest, IdleStreamsKeepNoLargeRequests) {
  const auto stream = CreateAndAttach(MazeSpec(1), {.requests_in_flight_max = 8});
  const v1::StepPoolRequest request = UnknownFields(80'000);
  procgen_client::Batch batch;
  ASSERT_THAT(stream->Observe(&batch), IsOk());
  const int64_t before = AllocatedBytes();
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 8; ++i) {
      ASSERT_THAT(stream->Send(request), IsOk());
    }
    for (int i = 0; i < 8; ++i) {
      ASSERT_THAT(stream->Receive(&batch), IsOk());
    }
  }
  EXPECT_TRUE(Eventually([&] { return AllocatedBytes() - before < 4 << 20; }))
      << AllocatedBytes() - before;
}

TEST_F(BuffersTest, RequestBeyondTheOwnersMemoryEndsTheStream) {
  const auto stream = CreateAndAttach(MazeSpec(1));
  EXPECT_THAT(CallStatus(stream.get(), UnknownFields(1'900'000)),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr(kLimit)));
}

// Sanitizers have allocators of their own.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(BuffersTest, DeletingAPoolReturnsMemoryToTheSystem) {
  const std::string pool = CreatePool(MazeSpec(1));
  // 56 MiB of free memory between blocks in use, which the allocator keeps until it is trimmed.
  std::vector<std::unique_ptr<char[]>> blocks(1024);
  for (auto& block : blocks) {
    block = std::make_unique<char[]>(64 << 10);
  }
  const int64_t before = ProcessResources::Of(getpid()).memory_bytes;
  for (size_t i = 0; i < blocks.size(); ++i) {
    if (i % 8 != 7) {
      blocks[i] = nullptr;
    }
  }
  ASSERT_GT(ProcessResources::Of(getpid()).memory_bytes, before - (8 << 20));
  ASSERT_THAT(client_->DeletePool(pool), IsOk());
  EXPECT_TRUE(Eventually(
      [&] { return ProcessResources::Of(getpid()).memory_bytes < before - (40 << 20); }));
}
#endif

}  // namespace
}  // namespace procgen
