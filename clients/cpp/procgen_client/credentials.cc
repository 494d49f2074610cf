#include "procgen_client/credentials.h"

#include <arpa/inet.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "absl/algorithm/container.h"
#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"

namespace procgen_client {

// Parses the whole address: "127.0.0.1.example.com" is a host name.
bool IsThisMachine(absl::string_view address) {
  constexpr uint8_t kLoopbackNet = 127;
  if (absl::StartsWith(address, "unix:")) {
    return true;
  }
  absl::ConsumePrefix(&address, "dns:///");
  absl::string_view text = address.substr(0, address.rfind(':'));
  if (absl::ConsumePrefix(&text, "[") && absl::ConsumeSuffix(&text, "]")) {
    in6_addr ipv6 = {};
    return inet_pton(AF_INET6, std::string(text).c_str(), &ipv6) == 1 &&
           IN6_IS_ADDR_LOOPBACK(&ipv6);
  }
  uint8_t ipv4[4] = {};
  return text == "localhost" ||
         (inet_pton(AF_INET, std::string(text).c_str(), ipv4) == 1 && ipv4[0] == kLoopbackNet);
}

namespace {

std::string Variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// Reads the file whose path is in an environment variable; no path: `text` is unchanged.
absl::Status ReadNamedFile(const char* variable, std::string* text) {
  const std::string path = Variable(variable);
  if (path.empty()) {
    return absl::OkStatus();
  }
  std::ifstream file(path, std::ios::binary);
  text->assign(std::istreambuf_iterator<char>(file), {});
  if (text->empty()) {
    return absl::NotFoundError(
        absl::StrCat(variable, " is ", path, ", which is empty or cannot be read"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Credentials> Credentials::FromEnvironment() {
  Credentials credentials;
  credentials.token = Variable("PROCGEN_SERVER_TOKEN");
  absl::Status status = ReadNamedFile("PROCGEN_SERVER_CA", &credentials.ca);
  status.Update(ReadNamedFile("PROCGEN_SERVER_CERTIFICATE", &credentials.certificate));
  status.Update(ReadNamedFile("PROCGEN_SERVER_KEY", &credentials.key));
  if (!status.ok()) {
    return status;
  }
  return credentials;
}

absl::Status CheckCredentials(const Credentials& credentials, const std::string& address) {
  if (credentials.certificate.empty() != credentials.key.empty()) {
    return absl::InvalidArgumentError(
        "a client certificate or its key is given alone, allowed: both or none");
  }
  if (absl::c_any_of(credentials.token, absl::ascii_isspace)) {
    return absl::InvalidArgumentError(
        "the token contains white space; of a line 'OWNER TOKEN' of the server's file it is the "
        "second word");
  }
  if (!credentials.ca.empty()) {
    return absl::OkStatus();
  }
  if (!credentials.certificate.empty()) {
    return absl::InvalidArgumentError(
        "a client certificate is given without the server's CA certificates (PROCGEN_SERVER_CA)");
  }
  if (!credentials.token.empty() && !credentials.token_in_plain_text && !IsThisMachine(address)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the token would go to ", address,
                     " in plain text; set the server's CA certificates (PROCGEN_SERVER_CA), or "
                     "token_in_plain_text"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> ChannelCredentialsOf(
    const Credentials& credentials, const std::string& address) {
  if (absl::Status status = CheckCredentials(credentials, address); !status.ok()) {
    return status;
  }
  if (credentials.ca.empty()) {
    return grpc::InsecureChannelCredentials();
  }
  grpc::SslCredentialsOptions options;
  options.pem_root_certs = credentials.ca;
  options.pem_cert_chain = credentials.certificate;
  options.pem_private_key = credentials.key;
  return grpc::SslCredentials(options);
}

void ShowToken(const std::string& token, grpc::ClientContext* context) {
  if (!token.empty()) {
    context->AddMetadata("authorization", absl::StrCat("Bearer ", token));
  }
}

}  // namespace procgen_client
