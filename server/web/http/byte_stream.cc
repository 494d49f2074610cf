#include "server/web/http/byte_stream.h"

#include <type_traits>

#include "boost/asio/post.hpp"
#include "boost/asio/ssl/stream_base.hpp"
#include "boost/beast/core/stream_traits.hpp"
#include "boost/beast/core/tcp_stream.hpp"
#include "boost/beast/ssl/ssl_stream.hpp"
#include "boost/beast/websocket/ssl.hpp"
#include "boost/beast/websocket/teardown.hpp"

namespace procgen::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;

using PlainStream = beast::tcp_stream;
using SecureStream = beast::ssl_stream<beast::tcp_stream>;

template <typename Stream>
class TransportOver final : public ByteStream::Transport {
 public:
  static constexpr bool kIsSecure = std::is_same_v<Stream, SecureStream>;

  // `context`: keeps that of TLS.
  TransportOver(Stream stream, std::shared_ptr<asio::ssl::context> context)
      : context_(std::move(context)), stream_(std::move(stream)) {}

  asio::ip::tcp::socket& Socket() override { return Lowest().socket(); }
  void ExpiresAfter(std::chrono::seconds timeout) override { Lowest().expires_after(timeout); }
  void ExpiresNever() override { Lowest().expires_never(); }
  void Close() override { Lowest().close(); }

  void Handshake(ByteStream::Handler handler) override {
    if constexpr (kIsSecure) {
      stream_.async_handshake(asio::ssl::stream_base::server, std::move(handler));
    } else {
      asio::post(Lowest().get_executor(),
                 [handler = std::move(handler)]() mutable { handler(error_code()); });
    }
  }

  void Shutdown(ByteStream::Handler handler) override {
    if constexpr (kIsSecure) {
      stream_.async_shutdown(std::move(handler));
    } else {
      error_code error;
      Socket().shutdown(asio::ip::tcp::socket::shutdown_send, error);
      asio::post(Lowest().get_executor(),
                 [handler = std::move(handler), error]() mutable { handler(error); });
    }
  }

  void TearDown(beast::role_type role, ByteStream::Handler handler) override {
    using beast::async_teardown;
    using beast::websocket::async_teardown;
    async_teardown(role, stream_, std::move(handler));
  }

  void ReadSome(asio::mutable_buffer buffer, ByteStream::IoHandler handler) override {
    stream_.async_read_some(buffer, std::move(handler));
  }

  void WriteSome(const ConstBuffers& buffers, ByteStream::IoHandler handler) override {
    stream_.async_write_some(buffers, std::move(handler));
  }

 private:
  beast::tcp_stream& Lowest() { return beast::get_lowest_layer(stream_); }

  const std::shared_ptr<asio::ssl::context> context_;
  Stream stream_;
};

std::unique_ptr<ByteStream::Transport> TransportOf(asio::ip::tcp::socket socket,
                                                   const std::shared_ptr<asio::ssl::context>& tls) {
  beast::tcp_stream stream(std::move(socket));
  if (tls == nullptr) {
    return std::make_unique<TransportOver<PlainStream>>(std::move(stream), nullptr);
  }
  return std::make_unique<TransportOver<SecureStream>>(SecureStream(std::move(stream), *tls), tls);
}

}  // namespace

ByteStream::ByteStream(asio::ip::tcp::socket socket, const std::shared_ptr<asio::ssl::context>& tls)
    : transport_(TransportOf(std::move(socket), tls)), is_secure_(tls != nullptr) {}

}  // namespace procgen::web
