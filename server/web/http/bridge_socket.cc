#include "server/web/http/bridge_socket.h"

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "boost/asio/buffer.hpp"
#include "boost/asio/post.hpp"
#include "boost/asio/steady_timer.hpp"
#include "boost/beast/core/flat_buffer.hpp"
#include "boost/beast/websocket.hpp"
#include "server/web/bridge/bridge_session.h"

namespace procgen::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using boost::system::error_code;

// Timeouts: for the handshake; for a page that answers no ping; for the first call that a method of
// the API answers; for the closing handshake.
constexpr std::chrono::seconds kHandshakeTimeout(10);
constexpr std::chrono::seconds kIdleTimeout(60);
constexpr std::chrono::seconds kFirstCallTimeout(10);
constexpr std::chrono::seconds kCloseTimeout(2);
// Unsent bytes in the kernel. More would delay small messages that overtake large ones.
constexpr int kUnsentBytesInKernelMax = 32 << 10;
// Size of the frames that a large message is sent in. Pings are sent between them.
constexpr size_t kFrameBytes = 64 << 10;
// Maximum length of a close reason in RFC 6455.
constexpr size_t kReasonBytesMax = 123;

// One WebSocket. Runs on the strand of its stream; BeginClose may be called from any thread.
class BridgeSocket final : public OpenSockets::Closable,
                           public std::enable_shared_from_this<BridgeSocket> {
 public:
  BridgeSocket(ByteStream stream, BridgeContext* context, OpenSockets* sockets)
      : socket_(std::move(stream)),
        context_(context),
        sockets_(sockets),
        timer_(socket_.get_executor()),
        has_room_(++context->viewers <= context->viewers_max) {
    if (!has_room_) {
      --context_->viewers;
    }
  }
  ~BridgeSocket() override {
    if (has_room_) {
      --context_->viewers;
    }
  }
  BridgeSocket(const BridgeSocket&) = delete;
  BridgeSocket& operator=(const BridgeSocket&) = delete;

  // Performs the WebSocket handshake and serves the socket until it is closed.
  void Start(const UpgradeRequest& request) {
    socket_.next_layer().ExpiresNever();  // the WebSocket has its own timeouts
    setsockopt(socket_.next_layer().Socket().native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT,
               &kUnsentBytesInKernelMax, sizeof(kUnsentBytesInKernelMax));
    websocket::stream_base::timeout timeouts = {};
    timeouts.handshake_timeout = kHandshakeTimeout;
    timeouts.idle_timeout = kIdleTimeout;
    timeouts.keep_alive_pings = true;
    socket_.set_option(timeouts);
    socket_.read_message_max(static_cast<size_t>(context_->message_bytes_max));
    socket_.write_buffer_bytes(kFrameBytes);
    socket_.binary(true);
    socket_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error || self->is_finished_) {
        self->Finish();
      } else {
        self->Serve();
      }
    });
  }

  void BeginClose() override {
    asio::post(socket_.get_executor(), [self = shared_from_this()] {
      self->Close({kCloseGoingAway, "the server stops"});
    });
  }

 private:
  void Serve() {
    is_open_ = true;
    if (is_closing_) {
      SendClose();
      return;
    }
    if (!has_room_) {
      Close({kCloseTryAgainLater,
             absl::StrCat("the server has no room for another page, --web_viewers_max is ",
                          context_->viewers_max)});
      return;
    }
    session_ = std::make_shared<BridgeSession>(
        context_->stub,
        [executor = socket_.get_executor()](absl::AnyInvocable<void()> work) {
          asio::post(executor, std::move(work));
        },
        [weak = weak_from_this()] {
          if (const std::shared_ptr<BridgeSocket> self = weak.lock(); self != nullptr) {
            self->Write();
            self->Read();
          }
        });
    timer_.expires_after(kFirstCallTimeout);
    timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error && !self->is_closing_ && !self->session_->is_accepted()) {
        self->Close({kClosePolicy, "no call was answered within 10 seconds"});
      }
    });
    Read();
  }

  void Read() {
    if (is_reading_ || is_closing_ || !session_->CanTake()) {
      return;
    }
    is_reading_ = true;
    socket_.async_read(buffer_, [self = shared_from_this()](error_code error, size_t) {
      self->is_reading_ = false;
      if (error) {
        self->Finish();
      } else if (!self->is_closing_) {
        self->Take();
        self->Read();
      }
    });
  }

  void Take() {
    std::optional<CloseReason> reason;
    if (socket_.got_text()) {
      reason = CloseReason{kCloseUnsupported, "the message is text, allowed: binary"};
    } else {
      const asio::const_buffer data = buffer_.cdata();
      reason =
          session_->Take(absl::string_view(static_cast<const char*>(data.data()), data.size()));
    }
    buffer_ = beast::flat_buffer();  // frees the memory of a large message
    if (reason.has_value()) {
      Close(*reason);
    } else {
      Write();
    }
  }

  void Write() {
    if (is_writing_ || is_closing_) {
      return;
    }
    std::optional<std::string> next = session_->Next();
    if (!next.has_value()) {
      return;
    }
    is_writing_ = true;
    sent_ = *std::move(next);
    socket_.async_write(asio::buffer(sent_), [self = shared_from_this()](error_code error, size_t) {
      self->is_writing_ = false;
      if (error) {
        self->Finish();
      } else if (self->is_closing_) {
        self->SendClose();
      } else {
        self->session_->OnWritten();
        self->Write();
        self->Read();
      }
    });
  }

  // Ends the calls, and closes the socket after the message that is being written.
  void Close(const CloseReason& reason) {
    if (is_closing_ || is_finished_) {
      return;
    }
    is_closing_ = true;
    reason_ = websocket::close_reason(static_cast<websocket::close_code>(reason.code),
                                      reason.text.substr(0, kReasonBytesMax));
    if (session_ != nullptr) {
      session_->Stop();
    }
    timer_.expires_after(kCloseTimeout);
    timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error) {
        self->Finish();
      }
    });
    if (is_open_ && !is_writing_) {
      SendClose();
    }
  }

  void SendClose() {
    socket_.async_close(reason_, [self = shared_from_this()](error_code) { self->Finish(); });
  }

  // Called when the connection has ended.
  void Finish() {
    if (std::exchange(is_finished_, true)) {
      return;
    }
    is_closing_ = true;
    if (session_ != nullptr) {
      session_->Stop();
    }
    timer_.cancel();
    socket_.next_layer().Close();
    sockets_->Remove(this);
  }

  websocket::stream<ByteStream, /*deflateSupported=*/false> socket_;
  BridgeContext* const context_;
  OpenSockets* const sockets_;
  asio::steady_timer timer_;                // for the first call, then for the close
  const bool has_room_;                     // counted as a viewer
  std::shared_ptr<BridgeSession> session_;  // null until the handshake is complete
  beast::flat_buffer buffer_;
  std::string sent_;  // the message being written
  websocket::close_reason reason_;
  bool is_open_ = false;  // the handshake is complete
  bool is_reading_ = false;
  bool is_writing_ = false;
  bool is_closing_ = false;
  bool is_finished_ = false;
};

}  // namespace

void OpenBridgeSocket(ByteStream stream, const UpgradeRequest& request, BridgeContext* context,
                      OpenSockets* sockets) {
  const auto socket = std::make_shared<BridgeSocket>(std::move(stream), context, sockets);
  if (sockets->Add(socket)) {
    socket->Start(request);
  }
}

}  // namespace procgen::web
