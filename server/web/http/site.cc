#include "server/web/http/site.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "absl/algorithm/container.h"
#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "openssl/sha.h"

namespace procgen::web {
namespace {

constexpr int kOk = 200;
constexpr int kNotModified = 304;
constexpr int kForbidden = 403;
constexpr int kNotFound = 404;
constexpr int kMethodNotAllowed = 405;
constexpr int kMisdirected = 421;
constexpr int kUpgradeRequired = 426;

constexpr absl::string_view kBridgePath = "/bridge";

absl::string_view ContentTypeOf(absl::string_view name) {
  static constexpr std::pair<absl::string_view, absl::string_view> kTypes[] = {
      {".binpb", "application/octet-stream"},
      {".css", "text/css; charset=utf-8"},
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".json", "application/json"},
      {".png", "image/png"},
      {".svg", "image/svg+xml"},
      {".woff2", "font/woff2"}};
  for (const auto& [suffix, type] : kTypes) {
    if (absl::EndsWith(name, suffix)) {
      return type;
    }
  }
  return "text/plain; charset=utf-8";
}

// The URL path of a file of pages/.
std::string PathOf(absl::string_view name) {
  if (name == "index.html") {
    return "/";
  }
  absl::string_view stem = name;
  if (absl::ConsumeSuffix(&stem, ".html") && !absl::StrContains(stem, '/')) {
    return absl::StrCat("/", stem);
  }
  return absl::StrCat("/assets/", name);
}

std::string EtagOf(absl::string_view contents) {
  constexpr size_t kShownBytes = 12;
  unsigned char digest[SHA256_DIGEST_LENGTH] = {};
  SHA256(reinterpret_cast<const unsigned char*>(contents.data()), contents.size(), digest);
  return absl::StrCat(
      "\"",
      absl::BytesToHexString(absl::string_view(reinterpret_cast<const char*>(digest), kShownBytes)),
      "\"");
}

// Whether `text` may follow a host name: empty, or a port.
bool IsPort(absl::string_view text) {
  int port = 0;
  return text.empty() ||
         (absl::ConsumePrefix(&text, ":") && absl::c_all_of(text, absl::ascii_isdigit) &&
          absl::SimpleAtoi(text, &port) && port <= UINT16_MAX);
}

// "name" of "name:80", "::1" of "[::1]:80"; empty if invalid.
std::string NameOf(absl::string_view host) {
  const bool has_brackets = absl::ConsumePrefix(&host, "[");
  const size_t end = std::min(host.find(has_brackets ? ']' : ':'), host.size());
  absl::string_view port = host.substr(end);
  if ((has_brackets && !absl::ConsumePrefix(&port, "]")) || !IsPort(port)) {
    return "";
  }
  return absl::AsciiStrToLower(host.substr(0, end));
}

// The path without the query, which only the page reads.
absl::string_view PathIn(absl::string_view target) { return target.substr(0, target.find('?')); }

Reply TextReply(int status, std::string text) {
  Reply reply;
  reply.status = status;
  reply.content_type = "text/plain; charset=utf-8";
  reply.text = std::move(text);
  return reply;
}

}  // namespace

Site::Site(std::vector<std::string> allowed_hosts, const std::vector<EmbeddedPage>& pages)
    : allowed_hosts_(std::move(allowed_hosts)) {
  for (const EmbeddedPage& page : pages) {
    absl::string_view name = page.name;
    if (absl::ConsumeSuffix(&name, ".gz")) {
      files_[PathOf(name)].gzip_contents = page.contents;
      continue;
    }
    File& file = files_[PathOf(name)];
    file.content_type = std::string(ContentTypeOf(name));
    file.contents = page.contents;
    file.etag = EtagOf(page.contents);
  }
}

bool Site::IsOurHost(const HttpRequestInfo& request) const {
  const std::string name = NameOf(request.host);
  return !name.empty() && (name == "localhost" || name == request.local_host ||
                           std::any_of(allowed_hosts_.begin(), allowed_hosts_.end(),
                                       [&name](const std::string& host) {
                                         return name == absl::AsciiStrToLower(host);
                                       }));
}

Reply Site::WrongHost(const HttpRequestInfo& request) {
  const bool is_short = request.host.size() <= 253 && !request.host.empty();
  return TextReply(kMisdirected,
                   absl::StrCat("This server does not accept the host name ",
                                is_short ? absl::CEscape(request.host) : "of the request",
                                ". Use its address, or start it with --web_allowed_hosts=NAME.\n"));
}

Reply Site::ReplyToSocket(const HttpRequestInfo& request) const {
  if (!IsOurHost(request)) {
    return WrongHost(request);
  }
  if (PathIn(request.target) != kBridgePath) {
    return TextReply(kNotFound, "Not found. The WebSocket is at /bridge.\n");
  }
  const std::string ours =
      absl::StrCat(request.is_secure ? "https://" : "http://", absl::AsciiStrToLower(request.host));
  if (absl::AsciiStrToLower(request.origin) != ours) {
    return TextReply(kForbidden,
                     "Only pages of this server may open its WebSocket: the header Origin must be "
                     "that of the address.\n");
  }
  Reply reply;
  reply.status = kSwitchingProtocols;
  return reply;
}

Reply Site::ReplyToPage(const HttpRequestInfo& request) const {
  if (!IsOurHost(request)) {
    return WrongHost(request);
  }
  if (request.method != "GET" && request.method != "HEAD") {
    return TextReply(kMethodNotAllowed, "Pages are there to be read: GET or HEAD.\n");
  }
  const absl::string_view path = PathIn(request.target);
  if (path == kBridgePath) {
    return TextReply(kUpgradeRequired, "This is a WebSocket.\n");
  }
  const auto found = files_.find(path);
  if (found == files_.end()) {
    return TextReply(kNotFound, "Page not found.\n");
  }
  const File& file = found->second;
  Reply reply;
  reply.content_type = file.content_type;
  reply.is_gzip = request.accepts_gzip && !file.gzip_contents.empty();
  // Each form has a tag of its own, as a strong tag requires.
  reply.etag =
      reply.is_gzip ? absl::StrCat(absl::StripSuffix(file.etag, "\""), "-gzip\"") : file.etag;
  reply.status = request.if_none_match == reply.etag ? kNotModified : kOk;
  if (reply.status == kOk) {
    reply.contents = reply.is_gzip ? file.gzip_contents : file.contents;
  }
  return reply;
}

std::vector<std::pair<std::string, std::string>> Site::SafetyHeaders(
    const HttpRequestInfo& request) {
  const bool is_host = std::all_of(request.host.begin(), request.host.end(), [](char letter) {
    return absl::ascii_isalnum(static_cast<unsigned char>(letter)) ||
           absl::StrContains("-._:[]", letter);
  });
  // Not all browsers apply 'self' to the scheme of the WebSocket.
  const std::string socket =
      is_host ? absl::StrCat(request.is_secure ? " wss://" : " ws://", request.host) : "";
  return {{"Content-Security-Policy",
           absl::StrCat("default-src 'none'; script-src 'self'; style-src 'self'; font-src 'self'; "
                        "img-src 'self' data: blob:; connect-src 'self'",
                        socket, "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'")},
          {"X-Content-Type-Options", "nosniff"},
          {"X-Frame-Options", "DENY"},
          {"Referrer-Policy", "no-referrer"},
          {"Cross-Origin-Opener-Policy", "same-origin"},
          {"Cross-Origin-Resource-Policy", "same-origin"},
          {"Cache-Control", "no-cache"}};
}

}  // namespace procgen::web
