#include "server/web/http/socket.h"

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <utility>
#include <vector>

#include "boost/asio/buffer.hpp"
#include "boost/asio/post.hpp"
#include "boost/asio/steady_timer.hpp"
#include "boost/beast/core/buffers_to_string.hpp"
#include "boost/beast/core/flat_buffer.hpp"
#include "boost/beast/websocket.hpp"

namespace procgen::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using boost::system::error_code;

// Timeouts: for hello; for the handshake; for a page that answers no ping; for writing queued
// messages when a socket closes.
constexpr std::chrono::seconds kHelloTimeout(10);
constexpr std::chrono::seconds kHandshakeTimeout(10);
constexpr std::chrono::seconds kIdleTimeout(60);
constexpr std::chrono::seconds kCloseTimeout(2);
// Limits of unanswered messages of a page; at a limit the server stops reading from it.
constexpr size_t kUnansweredMax = 16;
constexpr size_t kUnansweredBytesMax = 1 << 20;
// Message size limit before hello is accepted.
constexpr size_t kFirstMessageBytesMax = 4 << 10;
// Unsent bytes in the kernel. More would delay what is sent before frames.
constexpr int kUnsentBytesMax = 32 << 10;
// Maximum length of a close reason in RFC 6455.
constexpr size_t kReasonBytesMax = 123;

// One WebSocket. Runs on the strand of its stream. The methods of Outbox and BeginClose may be
// called from any thread and post to the strand.
class Socket final : public Outbox,
                     public OpenSockets::Closable,
                     public std::enable_shared_from_this<Socket> {
 public:
  Socket(ByteStream stream, const PageContext& context, OpenSockets* sockets)
      : socket_(std::move(stream)),
        context_(context),
        sockets_(sockets),
        timer_(socket_.get_executor()) {}

  // Performs the WebSocket handshake and serves the socket until it is closed.
  void Start(const UpgradeRequest& request) {
    socket_.next_layer().ExpiresNever();  // the WebSocket has its own timeouts
    setsockopt(socket_.next_layer().Socket().native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT,
               &kUnsentBytesMax, sizeof(kUnsentBytesMax));
    websocket::stream_base::timeout timeouts = {};
    timeouts.handshake_timeout = kHandshakeTimeout;
    timeouts.idle_timeout = kIdleTimeout;
    timeouts.keep_alive_pings = true;
    socket_.set_option(timeouts);
    socket_.read_message_max(kFirstMessageBytesMax);
    socket_.async_accept(request, [self = shared_from_this()](error_code error) {
      if (error) {
        self->Finish();
        return;
      }
      self->is_open_ = true;
      self->StartPageSession();
    });
  }

  void Answer(WireMessage message) override { Enqueue({std::move(message), "", true}); }
  void SendEvent(WireMessage message) override { Enqueue({std::move(message), "", false}); }

  void SendLatestEvent(const std::string& key, WireMessage message) override {
    OnStrand([key, message = std::move(message)](Socket& self) mutable {
      Replace({std::move(message), key, false}, &self.queue_);
      self.Write();
    });
  }

  void SendFrames(const std::string& key, absl::AnyInvocable<WireMessage()> compose) override {
    OnStrand([key, compose = std::move(compose)](Socket& self) mutable {
      Replace({std::move(compose), key}, &self.frames_);
      self.Write();
    });
  }

  void DropEvent(const std::string& key) override {
    OnStrand([key](Socket& self) {
      const auto is_of_key = [&key](const auto& queued) { return queued.key == key; };
      std::erase_if(self.queue_, is_of_key);
      std::erase_if(self.frames_, is_of_key);
    });
  }

  void AcceptHello() override {
    OnStrand([](Socket& self) {
      self.is_welcome_ = true;
      self.socket_.read_message_max(kMessageBytesMax);
      self.timer_.cancel();
    });
  }

  void Close(int code, std::string reason) override {
    OnStrand([code, reason = std::move(reason)](Socket& self) { self.CloseNow(code, reason); });
  }

  void BeginClose() override {
    SendEvent(EncodeEvent({{"event", "draining"}, {"message", "the server stops"}}));
    OnStrand([](Socket& self) {
      if (self.page_session_ != nullptr) {
        self.page_session_->Stop();
      }
      self.CloseNow(kCloseGoingAway, "the server stops");
    });
  }

 private:
  struct Outgoing {
    WireMessage message;
    std::string key;  // empty: none
    bool is_answer = false;
  };
  struct QueuedFrames {
    absl::AnyInvocable<WireMessage()> compose;
    std::string key;
  };

  template <typename Work>
  void OnStrand(Work work) {
    asio::post(socket_.get_executor(),
               [self = shared_from_this(), work = std::move(work)]() mutable {
                 if (!self->is_finished_) {
                   work(*self);
                 }
               });
  }

  void Enqueue(Outgoing outgoing) {
    OnStrand([outgoing = std::move(outgoing)](Socket& self) mutable {
      self.queue_.push_back(std::move(outgoing));
      self.Write();
    });
  }

  // Puts `latest` in the place of the one with the same key, or at the end.
  template <typename Queued>
  static void Replace(Queued latest, std::deque<Queued>* queue) {
    const auto same = std::find_if(queue->begin(), queue->end(), [&latest](const Queued& queued) {
      return queued.key == latest.key;
    });
    if (same != queue->end()) {
      *same = std::move(latest);
    } else {
      queue->push_back(std::move(latest));
    }
  }

  void StartPageSession() {
    if (is_closing_) {
      Write();
      return;
    }
    page_session_ = std::make_shared<PageSession>(*context_.session, shared_from_this());
    if (const absl::Status status =
            context_.threads->Start([page_session = page_session_] { page_session->Run(); });
        !status.ok()) {
      page_session_.reset();
      CloseNow(websocket::close_code::try_again_later, std::string(status.message()));
      return;
    }
    timer_.expires_after(kHelloTimeout);
    timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error && !self->is_welcome_ && !self->is_finished_) {
        self->CloseNow(kClosePolicy, "no hello that was accepted within 10 seconds");
      }
    });
    Read();
  }

  void Read() {
    const size_t bytes = UnansweredBytes();
    if (is_reading_ || is_closing_ || unanswered_.size() >= kUnansweredMax ||
        bytes >= kUnansweredBytesMax) {
      return;
    }
    is_reading_ = true;
    socket_.async_read(buffer_, [self = shared_from_this()](error_code error, size_t) {
      self->is_reading_ = false;
      if (error) {
        self->Finish();
        return;
      }
      self->TakeMessage();
      self->Read();
    });
  }

  size_t UnansweredBytes() const {
    size_t bytes = 0;
    for (const size_t size : unanswered_) {
      bytes += size;
    }
    return bytes;
  }

  void TakeMessage() {
    WireMessage message{beast::buffers_to_string(buffer_.data()), !socket_.got_text()};
    buffer_.consume(buffer_.size());
    if (!is_closing_) {
      unanswered_.push_back(message.bytes.size());
      page_session_->Take(std::move(message));
    }
  }

  void Write() {
    if (is_writing_) {
      return;
    }
    if ((queue_.empty() && frames_.empty()) || !is_open_) {
      if (is_closing_ && is_open_) {
        SendClose();
      }
      return;
    }
    is_writing_ = true;
    written_ = TakeNext();
    socket_.binary(written_.message.is_binary);
    socket_.async_write(asio::buffer(written_.message.bytes),
                        [self = shared_from_this()](error_code error, size_t) {
                          self->is_writing_ = false;
                          if (error) {
                            self->Finish();
                            return;
                          }
                          if (self->written_.is_answer && !self->unanswered_.empty()) {
                            self->unanswered_.pop_front();
                          }
                          self->Write();
                          self->Read();
                        });
  }

  // Frames come last, so that they delay nothing else.
  Outgoing TakeNext() {
    Outgoing next;
    if (!queue_.empty()) {
      next = std::move(queue_.front());
      queue_.pop_front();
    } else {
      next.message = frames_.front().compose();
      frames_.pop_front();
    }
    return next;
  }

  void CloseNow(int code, const std::string& reason) {
    if (is_closing_) {
      return;
    }
    is_closing_ = true;
    reason_ = websocket::close_reason(static_cast<websocket::close_code>(code),
                                      reason.substr(0, kReasonBytesMax));
    timer_.expires_after(kCloseTimeout);
    timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error) {
        self->Finish();
      }
    });
    Write();
  }

  void SendClose() {
    if (is_close_sent_) {
      return;
    }
    is_close_sent_ = true;
    socket_.async_close(reason_, [self = shared_from_this()](error_code) { self->Finish(); });
  }

  // Called when the connection has ended.
  void Finish() {
    if (is_finished_) {
      return;
    }
    is_finished_ = true;
    if (page_session_ != nullptr) {
      page_session_->Stop();
      page_session_.reset();  // it holds a reference to this
    }
    timer_.cancel();
    socket_.next_layer().Close();
    sockets_->Remove(this);
  }

  websocket::stream<ByteStream, /*deflateSupported=*/false> socket_;
  const PageContext& context_;
  OpenSockets* const sockets_;
  asio::steady_timer timer_;  // for hello, then for the close
  std::shared_ptr<PageSession> page_session_;
  beast::flat_buffer buffer_;
  std::deque<size_t> unanswered_;  // sizes of the messages
  std::deque<Outgoing> queue_;
  std::deque<QueuedFrames> frames_;  // of each key at most once
  Outgoing written_;                 // the message being written
  websocket::close_reason reason_;
  bool is_open_ = false;  // the handshake is complete
  bool is_welcome_ = false;
  bool is_reading_ = false;
  bool is_writing_ = false;
  bool is_closing_ = false;
  bool is_close_sent_ = false;
  bool is_finished_ = false;
};

}  // namespace

void OpenPageSocket(ByteStream stream, const UpgradeRequest& request, const PageContext& context,
                    OpenSockets* sockets) {
  const auto socket = std::make_shared<Socket>(std::move(stream), context, sockets);
  if (sockets->Add(socket)) {
    socket->Start(request);
  }
}

}  // namespace procgen::web
