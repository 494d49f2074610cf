// TLS and certificates: missing, invalid, expired or replaced ones.

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "procgen/v1/catalog.grpc.pb.h"
#include "tests/service/security/access_fixture.h"
#include "tests/service/service_fixture.h"
#include "tests/status_matchers.h"

namespace procgen {
namespace {

using procgen_client::Credentials;
using testing::AllOf;
using testing::HasSubstr;

class CredentialsTest : public AccessTest {
 protected:
  // Credentials that trust `authority`, with the client certificate `own` unless it is empty.
  Credentials Tls(const std::string& authority, const std::string& own = "",
                  const std::string& token = "") const {
    Credentials credentials = Token(token);
    credentials.ca = certificates_.Read(authority + ".pem");
    if (!own.empty()) {
      credentials.certificate = certificates_.Read(own + ".pem");
      credentials.key = certificates_.Read(own + ".key");
    }
    return credentials;
  }

  // The output of a server that cannot start with these flags.
  static std::string StartupErrorOf(std::vector<std::string> flags) {
    flags.insert(flags.begin(), "--address=127.0.0.1:0");
    ServerProcess server(flags);
    EXPECT_EQ(server.Wait(), 2);
    return server.rest();
  }

  bool Serves(const Credentials& credentials) const {
    grpc::ClientContext context;
    procgen_client::ShowToken(credentials.token, &context);
    v1::Catalog catalog;
    return v1::CatalogService::NewStub(ChannelWith(credentials))
        ->GetCatalog(&context, v1::GetCatalogRequest(), &catalog)
        .ok();
  }
};

TEST_F(CredentialsTest, TlsNeedsAClientThatTrustsTheServer) {
  Start(TlsFlags());
  certificates_.MakeAuthority("stranger");
  EXPECT_TRUE(Serves(Tls("authority")));
  EXPECT_FALSE(Serves(Tls("stranger")));
  EXPECT_FALSE(Serves(Credentials())) << "plain text";
}

TEST_F(CredentialsTest, TokensAreRequiredOverTls) {
  std::vector<std::string> flags = TlsFlags();
  flags.push_back("--tokens=" + certificates_.Path("tokens"));
  Start(flags);
  EXPECT_TRUE(Serves(Tls("authority", "", kAliceToken)));
  EXPECT_FALSE(Serves(Tls("authority")));
  EXPECT_FALSE(Serves(Tls("authority", "", "stranger-0123456789")));
}

TEST_F(CredentialsTest, ClientCertificatesMustBeSignedAndCurrent) {
  std::vector<std::string> flags = TlsFlags();
  certificates_.MakeAuthority("clients");
  flags.push_back("--tls_client_ca=" + certificates_.Path("clients.pem"));
  certificates_.Make("clients", "alice", "/CN=alice", "DNS:x");
  certificates_.Make("clients", "late", "/CN=late", "DNS:x", -1);
  certificates_.Make("authority", "stranger", "/CN=alice", "DNS:x");
  Start(flags);
  EXPECT_TRUE(Serves(Tls("authority", "alice")));
  EXPECT_FALSE(Serves(Tls("authority")));
  EXPECT_FALSE(Serves(Tls("authority", "late")));
  EXPECT_FALSE(Serves(Tls("authority", "stranger")));
}

TEST_F(CredentialsTest, CertificatesIdentifyOwnersWithoutTokens) {
  std::vector<std::string> flags = TlsFlags();
  flags.push_back("--tls_client_ca=" + certificates_.Path("authority.pem"));
  certificates_.Make("authority", "common", "/CN=Alice A", "DNS:x");
  certificates_.Make("authority", "uri", "/CN=someone", "DNS:x,URI:spiffe://lab/bob");
  certificates_.Make("authority", "nobody", "/O=lab", "DNS:x");
  Start(flags);
  const auto common = OpenStream(Tls("authority", "common"));
  const auto uri = OpenStream(Tls("authority", "uri"));
  EXPECT_EQ(common->Start(MazeSpec(1), {}, "a")->pool().owner(), "Alice A");
  EXPECT_EQ(uri->Start(MazeSpec(1), {}, "b")->pool().owner(), "spiffe://lab/bob");
  const auto client = Connect(Tls("authority", "uri"));
  ASSERT_THAT(client, IsOk());
  EXPECT_THAT((*client)->GetPool("pools/a"), StatusIs(absl::StatusCode::kNotFound, testing::_));
  const auto nobody = Connect(Tls("authority", "nobody"));
  ASSERT_THAT(nobody, IsOk());
  EXPECT_THAT((*nobody)->GetCatalog(),
              StatusIs(absl::StatusCode::kUnauthenticated, HasSubstr("has no name")));
}

TEST_F(CredentialsTest, TokenIdentifiesTheOwnerBeforeTheCertificate) {
  std::vector<std::string> flags = TlsFlags();
  flags.push_back("--tls_client_ca=" + certificates_.Path("authority.pem"));
  flags.push_back("--tokens=" + certificates_.Path("tokens"));
  certificates_.Make("authority", "carol", "/CN=carol", "DNS:x");
  Start(flags);
  EXPECT_FALSE(Serves(Tls("authority", "carol")));
  const auto run = OpenStream(Tls("authority", "carol", kAliceToken));
  EXPECT_EQ(run->Start(MazeSpec(1))->pool().owner(), "alice");
}

TEST_F(CredentialsTest, CertificatesAreReplacedWhileAStreamRuns) {
  Start(TlsFlags());
  const auto run = OpenStream(Tls("authority"));
  ASSERT_THAT(run->Start(MazeSpec(1)), IsOk());
  const std::string key = certificates_.Read("server.key");
  certificates_.MakeAuthority("next");
  certificates_.MakeServer("next", "next-server");

  certificates_.Replace("server.pem", "nonsense");
  EXPECT_TRUE(Serves(Tls("authority"))) << "the old certificate stays in use";
  certificates_.Replace("server.pem", certificates_.Read("next-server.pem"));
  EXPECT_TRUE(Serves(Tls("authority"))) << "while the key does not match";
  certificates_.Replace("server.key", certificates_.Read("next-server.key"));
  EXPECT_TRUE(Serves(Tls("next")));
  EXPECT_FALSE(Serves(Tls("authority")));
  v1::Batch batch;
  EXPECT_THAT(run->Step({4}, &batch), IsOk());
  EXPECT_THAT(StopAndReadLog(),
              AllOf(HasSubstr("server.pem: has no certificate in PEM"),
                    HasSubstr("is not the key of"), HasSubstr("event=certificates_reloaded")));
}

TEST_F(CredentialsTest, RemovedClientAuthoritiesAreRejected) {
  std::vector<std::string> flags = TlsFlags();
  certificates_.MakeAuthority("clients");
  certificates_.MakeAuthority("others");
  flags.push_back("--tls_client_ca=" + certificates_.Path("clients.pem"));
  certificates_.Make("clients", "alice", "/CN=alice", "DNS:x");
  Start(flags);
  EXPECT_TRUE(Serves(Tls("authority", "alice")));
  certificates_.Replace("clients.pem", certificates_.Read("others.pem"));
  EXPECT_FALSE(Serves(Tls("authority", "alice")));
}

TEST_F(CredentialsTest, InvalidFilesAreNamedAtStartup) {
  const std::vector<std::string> good = TlsFlags();
  certificates_.Write("locked.key", "-----BEGIN ENCRYPTED PRIVATE KEY-----\n");
  const std::string folder = certificates_.Path("");
  for (const auto& [flags, message] :
       {std::pair<std::vector<std::string>, std::string>{
            {"--tls_certificate=" + folder + "none.pem", good[1]},
            "--tls_certificate: " + folder + "none.pem: No such file or directory"},
        {{"--tls_certificate=" + folder + "server.key", good[1]},
         "--tls_certificate: " + folder + "server.key: has no certificate in PEM"},
        {{good[0], "--tls_key=" + folder + "server.pem"},
         "--tls_key: " + folder + "server.pem: has no private key in PEM"},
        {{good[0], "--tls_key=" + folder + "locked.key"},
         "--tls_key: " + folder + "locked.key: has no private key in PEM without a password"},
        {{good[0], "--tls_key=" + folder + "authority.key"},
         absl::StrCat("--tls_key: ", folder, "authority.key: is not the key of ", folder,
                      "server.pem")},
        {{good[0], good[1], "--tls_client_ca=" + folder + "tokens"},
         "--tls_client_ca: " + folder + "tokens: has no certificate in PEM"},
        {{"--tokens=" + folder + "none"}, "--tokens: " + folder + "none: No such file"},
        {{"--tokens=" + folder + "server.pem"}, "--tokens: " + folder + "server.pem: line "}}) {
    EXPECT_THAT(StartupErrorOf(flags), HasSubstr(message));
  }
}

TEST_F(CredentialsTest, ClientsSendNoTokenToOtherMachinesInPlainText) {
  for (const char* address : {"example.com:1", "127.0.0.1.example.com:1", "10.0.0.1:1"}) {
    EXPECT_THAT(procgen_client::ChannelCredentialsOf(Token(kAliceToken), address),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr("in plain text"), testing::Not(HasSubstr(kAliceToken)))));
  }
  for (const char* address : {"localhost:1", "127.0.0.1:1", "[::1]:1", "unix:/x"}) {
    EXPECT_THAT(procgen_client::ChannelCredentialsOf(Token(kAliceToken), address), IsOk());
  }
  Credentials credentials = Token(kAliceToken);
  credentials.token_in_plain_text = true;
  EXPECT_THAT(procgen_client::ChannelCredentialsOf(credentials, "example.com:1"), IsOk());
}

}  // namespace
}  // namespace procgen
