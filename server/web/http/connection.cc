#include "server/web/http/connection.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "boost/asio/dispatch.hpp"
#include "boost/beast/core/flat_buffer.hpp"
#include "boost/beast/http.hpp"
#include "boost/beast/websocket/rfc6455.hpp"

namespace procgen::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::system::error_code;

// Timeout of the TLS handshake, of each request (also on an idle connection) and of each reply.
constexpr std::chrono::seconds kAskTimeout(10);
constexpr std::chrono::seconds kAnswerTimeout(30);
constexpr uint32_t kHeaderBytesMax = 8 << 10;

// The value of a header; empty if it is missing or repeated.
std::string HeaderOf(const UpgradeRequest& request, http::field name) {
  const auto [begin, end] = request.equal_range(name);
  if (begin == end || std::next(begin) != end) {
    return "";
  }
  return std::string(begin->value());
}

// Whether the browser accepts gzip: it lists it, and not with the weight 0.
bool AcceptsGzip(const UpgradeRequest& request) {
  for (const auto& [coding, parameters] : http::ext_list(request[http::field::accept_encoding])) {
    if (coding == "gzip") {
      return std::all_of(parameters.begin(), parameters.end(), [](const auto& parameter) {
        return parameter.first != "q" ||
               parameter.second.find_first_not_of("0.") != parameter.second.npos;
      });
    }
  }
  return false;
}

// An address in the form of a Host header; an IPv4-mapped address of a dual-stack socket as IPv4.
std::string TextOf(const asio::ip::address& address) {
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).to_string();
  }
  return address.to_string();
}

class Connection final : public std::enable_shared_from_this<Connection> {
 public:
  Connection(ByteStream stream, const ConnectionContext& context)
      : stream_(std::move(stream)), context_(context) {
    error_code error;
    local_host_ = TextOf(stream_.Socket().local_endpoint(error).address());
  }

  void Start() {
    stream_.ExpiresAfter(kAskTimeout);
    stream_.Handshake([self = shared_from_this()](error_code error) {
      if (!error) {
        self->Read();
      }
    });
  }

 private:
  void Read() {
    parser_.emplace();
    parser_->header_limit(kHeaderBytesMax);
    parser_->body_limit(0);
    stream_.ExpiresAfter(kAskTimeout);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](error_code error, size_t) {
                       if (error) {
                         self->RejectInvalidRequest(error);
                         return;
                       }
                       self->Reply();
                     });
  }

  // Called for invalid requests; replies 400 unless the connection broke.
  void RejectInvalidRequest(error_code error) {
    if (error == http::error::end_of_stream || error == beast::error::timeout ||
        error.category() != http::make_error_code(http::error::bad_method).category()) {
      return;
    }
    HttpRequestInfo info;
    Write(info, {400, "text/plain; charset=utf-8", "", "Invalid request.\n", ""},
          /*keep_alive=*/false);
  }

  HttpRequestInfo InfoOf(const UpgradeRequest& request) const {
    HttpRequestInfo info;
    info.method = std::string(request.method_string());
    info.target = std::string(request.target());
    info.host = HeaderOf(request, http::field::host);
    info.origin = HeaderOf(request, http::field::origin);
    info.if_none_match = HeaderOf(request, http::field::if_none_match);
    info.accepts_gzip = AcceptsGzip(request);
    info.wants_socket = beast::websocket::is_upgrade(request);
    info.local_host = local_host_;
    info.is_secure = stream_.is_secure();
    return info;
  }

  void Reply() {
    const UpgradeRequest request = parser_->release();
    const HttpRequestInfo info = InfoOf(request);
    if (!info.wants_socket) {
      Write(info, context_.site->ReplyToPage(info), request.keep_alive());
      return;
    }
    const web::Reply reply = context_.site->ReplyToSocket(info);
    if (reply.status == kSwitchingProtocols) {
      OpenBridgeSocket(std::move(stream_), request, context_.bridge, context_.sockets);
      return;
    }
    Write(info, reply, /*keep_alive=*/false);
  }

  void Write(const HttpRequestInfo& info, const web::Reply& reply, bool keep_alive) {
    response_ = {};
    response_.result(static_cast<unsigned>(reply.status));
    for (const auto& [name, value] : Site::SafetyHeaders(info)) {
      response_.set(name, value);
    }
    response_.set(http::field::content_type, reply.content_type);
    if (!reply.etag.empty()) {
      response_.set(http::field::etag, reply.etag);
    }
    if (reply.is_gzip) {
      response_.set(http::field::content_encoding, "gzip");
    }
    response_.set(http::field::vary, "Accept-Encoding");
    if (reply.status == 405) {
      response_.set(http::field::allow, "GET, HEAD");
    }
    std::string body = reply.text.empty() ? std::string(reply.contents) : reply.text;
    if (reply.status != 304) {
      response_.content_length(body.size());
    }
    if (info.method != "HEAD") {
      response_.body() = std::move(body);
    }
    response_.keep_alive(keep_alive);
    stream_.ExpiresAfter(kAnswerTimeout);
    http::async_write(stream_, response_,
                      [self = shared_from_this(), keep_alive](error_code error, size_t) {
                        if (error) {
                          return;
                        }
                        if (keep_alive) {
                          self->Read();
                        } else {
                          self->Close();
                        }
                      });
  }

  void Close() {
    stream_.ExpiresAfter(kAskTimeout);
    stream_.Shutdown([self = shared_from_this()](error_code) {});
  }

  ByteStream stream_;
  const ConnectionContext& context_;
  std::string local_host_;
  beast::flat_buffer buffer_{kHeaderBytesMax * 2};
  std::optional<http::request_parser<http::empty_body>> parser_;
  http::response<http::string_body> response_;
};

}  // namespace

void StartConnection(asio::ip::tcp::socket socket, const std::shared_ptr<asio::ssl::context>& tls,
                     const ConnectionContext& context) {
  // On a strand, so that the handlers of a connection do not run concurrently.
  const auto executor = socket.get_executor();
  auto connection = std::make_shared<Connection>(ByteStream(std::move(socket), tls), context);
  asio::dispatch(executor, [connection] { connection->Start(); });
}

}  // namespace procgen::web
