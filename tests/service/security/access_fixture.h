#ifndef TESTS_SERVICE_SECURITY_ACCESS_FIXTURE_H_
#define TESTS_SERVICE_SECURITY_ACCESS_FIXTURE_H_

#include <memory>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "procgen_client/client.h"
#include "tests/service/security/certificates.h"
#include "tests/service/server_process.h"

namespace procgen {

inline constexpr char kAliceToken[] = "alice-token-0123456789";
inline constexpr char kBobToken[] = "bob-token-01234567890123";

// A procgen-server process with authentication: Alice and Bob have tokens.
class AccessTest : public testing::Test {
 protected:
  void SetUp() override;

  // Starts the server with these flags besides, and waits until it listens.
  void Start(const std::vector<std::string>& flags = {});
  // Flags of a server with the certificate "server" of the authority "authority", made here.
  std::vector<std::string> TlsFlags();

  // What a client shows; `token` empty: none.
  static procgen_client::Credentials Token(const std::string& token);
  // A connection to the server.
  absl::StatusOr<std::unique_ptr<procgen_client::Client>> Connect(
      const procgen_client::Credentials& credentials);
  std::unique_ptr<procgen_client::Client> ConnectAs(const std::string& token);

  // Stops it and returns all that it printed since it listened. Once.
  std::string StopAndReadLog();

  Certificates certificates_;
  std::unique_ptr<ServerProcess> server_;
  std::string address_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_SECURITY_ACCESS_FIXTURE_H_
