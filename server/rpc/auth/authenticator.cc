#include "server/rpc/auth/authenticator.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "grpc/grpc_security_constants.h"
#include "grpcpp/security/auth_context.h"

namespace procgen {
namespace {

constexpr char kTokenKey[] = "authorization";
constexpr absl::string_view kScheme = "Bearer ";

// Returns the value of the metadata "authorization"; nullopt unless there is exactly one.
std::optional<absl::string_view> AuthorizationOf(const grpc::ServerContextBase& context) {
  const auto [begin, end] = context.client_metadata().equal_range(kTokenKey);
  if (begin == end || std::next(begin) != end) {
    return std::nullopt;
  }
  return absl::string_view(begin->second.data(), begin->second.size());
}

// Whether `name` is valid in logs and messages.
bool IsOwner(absl::string_view name) {
  return !name.empty() && name.size() <= kOwnerLengthMax &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char letter) { return absl::ascii_isprint(letter); });
}

absl::StatusOr<std::string> OwnerByCertificate(const grpc::AuthContext& peer) {
  for (const char* property : {GRPC_PEER_URI_PROPERTY_NAME, GRPC_X509_CN_PROPERTY_NAME}) {
    const std::vector<grpc::string_ref> names = peer.FindPropertyValues(property);
    if (names.empty()) {
      continue;
    }
    std::string name(names.front().data(), names.front().size());
    if (IsOwner(name)) {
      return name;
    }
    break;
  }
  return absl::UnauthenticatedError(absl::StrCat(
      "the client's certificate has no name; expected a URI among its alternative names or a "
      "common name, of 1 to ",
      kOwnerLengthMax, " printable ASCII characters"));
}

}  // namespace

Authenticator::Authenticator(std::shared_ptr<TokenFile> tokens, bool use_certificates)
    : tokens_(std::move(tokens)), use_certificates_(use_certificates) {}

absl::StatusOr<std::string> Authenticator::OwnerOf(const grpc::ServerContextBase& context) const {
  if (tokens_ != nullptr) {
    return OwnerByToken(context);
  }
  if (use_certificates_) {
    return OwnerByCertificate(*context.auth_context());
  }
  return "";
}

absl::StatusOr<std::string> Authenticator::OwnerByToken(
    const grpc::ServerContextBase& context) const {
  constexpr absl::string_view kExpected =
      "expected: metadata 'authorization: Bearer TOKEN', once, with a token of this server";
  const std::optional<absl::string_view> authorization = AuthorizationOf(context);
  if (!authorization.has_value() || !absl::StartsWithIgnoreCase(*authorization, kScheme)) {
    return absl::UnauthenticatedError(absl::StrCat("the call has no token; ", kExpected));
  }
  std::optional<std::string> owner =
      tokens_->OwnerOf(absl::StripAsciiWhitespace(authorization->substr(kScheme.size())));
  if (!owner.has_value()) {
    return absl::UnauthenticatedError(
        absl::StrCat("the call's token is not one of this server's; ", kExpected));
  }
  return *std::move(owner);
}

}  // namespace procgen
