#ifndef SERVER_WEB_HTTP_BYTE_STREAM_H_
#define SERVER_WEB_HTTP_BYTE_STREAM_H_

#include <array>
#include <chrono>
#include <cstddef>
#include <memory>
#include <utility>

#include "absl/functional/any_invocable.h"
#include "boost/asio/async_result.hpp"
#include "boost/asio/buffer.hpp"
#include "boost/asio/ip/tcp.hpp"
#include "boost/asio/ssl/context.hpp"
#include "boost/beast/core/role.hpp"
#include "boost/system/error_code.hpp"

namespace procgen::web {

// A TCP connection, with or without TLS: the AsyncStream of Boost.Beast. One type for both, with
// handlers of one type, because Beast is compiled again for each: a WebSocket of two streams and
// Beast's own handlers took 43 s. Handlers run on the executor of the socket, a strand.
// Threads: on the strand.
class ByteStream {
 public:
  // NOLINTNEXTLINE(readability-identifier-naming): Asio's name
  using executor_type = boost::asio::ip::tcp::socket::executor_type;
  using IoHandler = absl::AnyInvocable<void(boost::system::error_code, size_t)>;
  using Handler = absl::AnyInvocable<void(boost::system::error_code)>;

  // A connection and what is done with it. Implemented with and without TLS.
  class Transport {
   public:
    using ConstBuffers = std::array<boost::asio::const_buffer, 2>;

    virtual ~Transport() = default;
    virtual boost::asio::ip::tcp::socket& Socket() = 0;
    virtual void ExpiresAfter(std::chrono::seconds timeout) = 0;
    virtual void ExpiresNever() = 0;
    virtual void Close() = 0;
    virtual void Handshake(Handler handler) = 0;
    virtual void Shutdown(Handler handler) = 0;
    virtual void TearDown(boost::beast::role_type role, Handler handler) = 0;
    virtual void ReadSome(boost::asio::mutable_buffer buffer, IoHandler handler) = 0;
    virtual void WriteSome(const ConstBuffers& buffers, IoHandler handler) = 0;
  };

  // A null `tls` means plain text.
  ByteStream(boost::asio::ip::tcp::socket socket,
             const std::shared_ptr<boost::asio::ssl::context>& tls);

  bool is_secure() const { return is_secure_; }
  boost::asio::ip::tcp::socket& Socket() { return transport_->Socket(); }
  executor_type get_executor() noexcept { return transport_->Socket().get_executor(); }

  // Fails the operations that are in progress after `timeout`.
  void ExpiresAfter(std::chrono::seconds timeout) { transport_->ExpiresAfter(timeout); }
  void ExpiresNever() { transport_->ExpiresNever(); }
  void Close() { transport_->Close(); }
  // The handshake of TLS. Immediate without it.
  void Handshake(Handler handler) { transport_->Handshake(std::move(handler)); }
  // Ends the stream in the direction to the peer.
  void Shutdown(Handler handler) { transport_->Shutdown(std::move(handler)); }

  template <typename MutableBuffers, typename Token>
  auto async_read_some(const MutableBuffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(boost::system::error_code, size_t)>(
        [](auto handler, ByteStream* self, boost::asio::mutable_buffer buffer) {
          self->transport_->ReadSome(buffer, IoHandler(std::move(handler)));
        },
        token, this, FirstOf<boost::asio::mutable_buffer, 1>(buffers)[0]);
  }

  template <typename ConstBuffers, typename Token>
  auto async_write_some(const ConstBuffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(boost::system::error_code, size_t)>(
        [](auto handler, ByteStream* self, const Transport::ConstBuffers& first) {
          self->transport_->WriteSome(first, IoHandler(std::move(handler)));
        },
        token, this, FirstOf<boost::asio::const_buffer, 2>(buffers));
  }

  // Customisation points of Beast, found by their names.
  friend void beast_close_socket(ByteStream& stream) { stream.Close(); }
  friend void teardown(boost::beast::role_type /*role*/, ByteStream& stream,
                       boost::system::error_code& /*error*/) {
    stream.Close();
  }
  template <typename TearDownHandler>
  friend void async_teardown(boost::beast::role_type role, ByteStream& stream,
                             TearDownHandler&& handler) {
    stream.transport_->TearDown(role, Handler(std::forward<TearDownHandler>(handler)));
  }

 private:
  // The first `count` buffers that are not empty: an operation may handle fewer bytes than it
  // could.
  template <typename Buffer, size_t count, typename Buffers>
  static std::array<Buffer, count> FirstOf(const Buffers& buffers) {
    std::array<Buffer, count> first;
    size_t found = 0;
    // NOLINTBEGIN(readability-qualified-auto): the iterators of some sequences are pointers
    const auto end = boost::asio::buffer_sequence_end(buffers);
    for (auto at = boost::asio::buffer_sequence_begin(buffers); at != end && found < count; ++at) {
      // NOLINTEND(readability-qualified-auto)
      if (const Buffer buffer = *at; buffer.size() > 0) {
        first[found++] = buffer;
      }
    }
    return first;
  }

  std::unique_ptr<Transport> transport_;
  bool is_secure_;
};

}  // namespace procgen::web

#endif  // SERVER_WEB_HTTP_BYTE_STREAM_H_
