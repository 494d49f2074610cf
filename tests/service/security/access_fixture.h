#ifndef TESTS_SERVICE_SECURITY_ACCESS_FIXTURE_H_
#define TESTS_SERVICE_SECURITY_ACCESS_FIXTURE_H_

#include <memory>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/pool_stream.h"
#include "tests/service/security/certificates.h"
#include "tests/service/server_process.h"

namespace procgen {

inline constexpr char kAliceToken[] = "alice-token-0123456789";
inline constexpr char kBobToken[] = "bob-token-01234567890123";

// A procgen-server process with authentication: Alice and Bob have tokens.
class AccessTest : public testing::Test {
 protected:
  void SetUp() override;

  // Starts the server with additional `flags` and waits until it listens.
  void Start(const std::vector<std::string>& flags = {});
  // Flags for TLS with the new certificate "server", signed by the new authority "authority".
  std::vector<std::string> TlsFlags();

  // Credentials with a token; empty: none.
  static procgen_client::Credentials Token(const std::string& token);
  // Connects to the server.
  absl::StatusOr<std::unique_ptr<procgen_client::Client>> Connect(
      const procgen_client::Credentials& credentials);
  std::unique_ptr<procgen_client::Client> ConnectAs(const std::string& token);
  // A connection of its own, without retries.
  std::shared_ptr<grpc::Channel> ChannelWith(const procgen_client::Credentials& credentials) const;
  // Opens a stream.
  std::unique_ptr<PoolStream> OpenStream(const procgen_client::Credentials& credentials) const;
  std::unique_ptr<PoolStream> OpenStream(const std::string& token) const {
    return OpenStream(Token(token));
  }

  // Kills the server and returns its output since it listened. Call it once.
  std::string StopAndReadLog();

  Certificates certificates_;
  std::unique_ptr<ServerProcess> server_;
  std::string address_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_SECURITY_ACCESS_FIXTURE_H_
