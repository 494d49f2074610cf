#include "server/web/web_server.h"

#include <unistd.h>

#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "boost/asio/buffer.hpp"
#include "boost/asio/executor_work_guard.hpp"
#include "boost/asio/io_context.hpp"
#include "boost/asio/ip/tcp.hpp"
#include "boost/asio/ssl/context.hpp"
#include "boost/asio/strand.hpp"
#include "server/net/address.h"
#include "server/net/listener.h"
#include "server/web/http/bridge_socket.h"
#include "server/web/http/connection.h"
#include "server/web/http/embedded_pages.h"
#include "server/web/http/open_sockets.h"
#include "server/web/http/site.h"

namespace procgen::web {
namespace {

namespace asio = boost::asio;

constexpr int kIoThreadCount = 2;
// Bytes of a BridgeRequest besides its message.
constexpr int64_t kEnvelopeBytes = 64;
// Grace period for sockets at shutdown, in addition to their close timeout.
constexpr absl::Duration kStopTimeout = absl::Seconds(3);

std::string UrlOf(const Address& address, uint16_t port, bool is_secure) {
  const bool is_ipv6 = absl::StrContains(address.host, ':');
  return absl::StrCat(is_secure ? "https://" : "http://", is_ipv6 ? "[" : "", address.host,
                      is_ipv6 ? "]" : "", ":", port, "/");
}

std::vector<std::string> HostsOf(const WebOptions& options, const Address& address) {
  std::vector<std::string> hosts = options.allowed_hosts;
  hosts.push_back(address.host);
  return hosts;
}

// Allows TLS 1.2 and 1.3 only.
std::shared_ptr<asio::ssl::context> ContextOf(const TlsFiles::Contents& contents) {
  auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_server);
  context->set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_sslv2 |
                       asio::ssl::context::no_sslv3 | asio::ssl::context::no_tlsv1 |
                       asio::ssl::context::no_tlsv1_1);
  context->use_certificate_chain(asio::buffer(contents.certificate));
  context->use_private_key(asio::buffer(contents.key), asio::ssl::context::pem);
  if (!contents.client_ca.empty()) {
    context->add_certificate_authority(asio::buffer(contents.client_ca));
    context->set_verify_mode(asio::ssl::verify_peer | asio::ssl::verify_fail_if_no_peer_cert);
  }
  return context;
}

class BeastServer final : public WebServer {
 public:
  BeastServer(const WebOptions& options, const Address& address, std::unique_ptr<Listener> listener)
      : url_(UrlOf(address, listener->port(), options.tls != nullptr)),
        site_(HostsOf(options, address), EmbeddedPages()),
        tls_files_(options.tls),
        stub_(options.make_stub()),
        connection_context_{&site_, &bridge_context_, &sockets_},
        work_(asio::make_work_guard(io_)),
        listener_(std::move(listener)) {
    for (int i = 0; i < kIoThreadCount; ++i) {
      io_threads_.emplace_back([this] { io_.run(); });
    }
    bridge_context_.stub = stub_.get();
    bridge_context_.message_bytes_max = options.request_bytes_max + kEnvelopeBytes;
    bridge_context_.viewers_max = options.viewers_max;
    listener_->Start([this](int /*listening*/, int connection) { Take(connection); });
  }

  ~BeastServer() override {
    BeginClose();
    sockets_.AwaitClosed(kStopTimeout);
    io_.stop();
    for (std::thread& thread : io_threads_) {
      thread.join();
    }
    stub_.reset();  // waits for the calls of the sockets, which have cancelled them
  }

  void BeginClose() override {
    listener_.reset();
    sockets_.BeginClose();
  }

  const std::string& url() const override { return url_; }

 private:
  // Called on the listener's thread.
  void Take(int connection) {
    asio::ip::tcp::socket socket(asio::make_strand(io_));
    sockaddr_storage local = {};
    socklen_t size = sizeof(local);
    boost::system::error_code error;
    if (getsockname(connection, reinterpret_cast<sockaddr*>(&local), &size) == 0) {
      socket.assign(local.ss_family == AF_INET6 ? asio::ip::tcp::v6() : asio::ip::tcp::v4(),
                    connection, error);
    }
    if (!socket.is_open()) {
      close(connection);
      return;
    }
    socket.set_option(asio::ip::tcp::no_delay(true), error);
    if (tls_files_ != nullptr) {
      const auto [contents, version] = tls_files_->Current();
      if (version != tls_version_) {
        tls_ = ContextOf(contents);  // the files were validated when they were read
        tls_version_ = version;
      }
    }
    StartConnection(std::move(socket), tls_, connection_context_);
  }

  const std::string url_;
  const Site site_;
  const std::shared_ptr<TlsFiles> tls_files_;  // null: plain text
  // Of new connections; used only by the listener's thread.
  std::shared_ptr<asio::ssl::context> tls_;
  int64_t tls_version_ = 0;
  std::unique_ptr<GenericStub> stub_;
  BridgeContext bridge_context_;
  OpenSockets sockets_;
  const ConnectionContext connection_context_;
  asio::io_context io_;  // its pending handlers are destroyed before the other members
  asio::executor_work_guard<asio::io_context::executor_type> work_;
  std::vector<std::thread> io_threads_;
  std::unique_ptr<Listener> listener_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<WebServer>> WebServer::Start(const WebOptions& options) {
  const absl::StatusOr<Address> address = ParseAddress(options.address);
  if (!address.ok()) {
    return address.status();
  }
  absl::StatusOr<std::unique_ptr<Listener>> listener = Listener::Listen(*address);
  if (!listener.ok()) {
    return absl::UnavailableError(
        absl::StrCat("cannot serve pages at ", options.address, ": ", listener.status().message()));
  }
  return std::make_unique<BeastServer>(options, *address, *std::move(listener));
}

}  // namespace procgen::web
