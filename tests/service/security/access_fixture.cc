#include "tests/service/security/access_fixture.h"

#include <csignal>

#include "absl/strings/str_cat.h"
#include "grpcpp/create_channel.h"
#include "tests/status_matchers.h"

namespace procgen {

void AccessTest::SetUp() {
  certificates_.Write("tokens",
                      absl::StrCat("alice ", kAliceToken, "\nbob ", kBobToken, "  # a friend\n"));
}

void AccessTest::Start(const std::vector<std::string>& flags) {
  std::vector<std::string> all = {"--address=127.0.0.1:0", "--workers=1", "--log_level=debug"};
  all.insert(all.end(), flags.begin(), flags.end());
  server_ = std::make_unique<ServerProcess>(all);
  address_ = server_->Address();
  ASSERT_NE(address_, "");
}

std::vector<std::string> AccessTest::TlsFlags() {
  certificates_.MakeAuthority("authority");
  certificates_.MakeServer("authority", "server");
  return {"--tls_certificate=" + certificates_.Path("server.pem"),
          "--tls_key=" + certificates_.Path("server.key")};
}

procgen_client::Credentials AccessTest::Token(const std::string& token) {
  procgen_client::Credentials credentials;
  credentials.token = token;
  return credentials;
}

absl::StatusOr<std::unique_ptr<procgen_client::Client>> AccessTest::Connect(
    const procgen_client::Credentials& credentials) {
  procgen_client::ConnectOptions options;
  options.credentials = credentials;
  options.timeout = absl::Seconds(30);
  return procgen_client::Client::Connect(address_, options);
}

std::unique_ptr<procgen_client::Client> AccessTest::ConnectAs(const std::string& token) {
  auto client = Connect(Token(token));
  EXPECT_THAT(client, IsOk());
  return client.ok() ? *std::move(client) : nullptr;
}

std::shared_ptr<grpc::Channel> AccessTest::ChannelWith(
    const procgen_client::Credentials& credentials) const {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(
      address_, *procgen_client::ChannelCredentialsOf(credentials, address_), arguments);
}

std::unique_ptr<PoolStream> AccessTest::OpenStream(
    const procgen_client::Credentials& credentials) const {
  return std::make_unique<PoolStream>(ChannelWith(credentials), credentials.token);
}

std::string AccessTest::StopAndReadLog() {
  // Not SIGKILL: the last lines would be missing, as a thread writes them.
  server_->Signal(SIGTERM);
  server_->Wait();
  return server_->rest();
}

}  // namespace procgen
