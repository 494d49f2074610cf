#include "server/web/web_server.h"

#include <unistd.h>

#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "boost/asio/executor_work_guard.hpp"
#include "boost/asio/io_context.hpp"
#include "boost/asio/ip/tcp.hpp"
#include "boost/asio/strand.hpp"
#include "server/concurrency/thread_group.h"
#include "server/net/address.h"
#include "server/net/listener.h"
#include "server/web/http/bridge_socket.h"
#include "server/web/http/connection.h"
#include "server/web/http/embedded_pages.h"
#include "server/web/http/open_sockets.h"
#include "server/web/http/site.h"
#include "server/web/http/socket.h"
#include "server/web/http/tls_contexts.h"
#include "server/web/session/page_session.h"
#include "server/web/session/pool_feed.h"

namespace procgen::web {
namespace {

namespace asio = boost::asio;

constexpr int kIoThreadCount = 2;
// Connections in addition to viewers' sockets: HTTP requests and silent connections.
constexpr int32_t kOtherConnectionsMax = 192;
// Bytes of a BridgeRequest besides its message.
constexpr int64_t kEnvelopeBytes = 64;
// Timeout of in-process calls; longer than any call takes.
constexpr absl::Duration kCallTimeout = absl::Seconds(60);
// Grace period for sockets at shutdown, in addition to their close timeout.
constexpr absl::Duration kCloseTimeout = absl::Seconds(3);

std::string UrlOf(const Address& address, uint16_t port, bool is_secure) {
  const bool is_ipv6 = absl::StrContains(address.host, ':');
  return absl::StrCat(is_secure ? "https://" : "http://", is_ipv6 ? "[" : "", address.host,
                      is_ipv6 ? "]" : "", ":", port, "/");
}

PageSessionContext PageSessionContextOf(const WebOptions& options, PoolFeed* feed,
                                        ThreadGroup* watch_threads, DifferenceCache* differences) {
  PageSessionContext context;
  context.version = options.version;
  context.requires_token = options.requires_token;
  context.viewers_max = options.viewers_max;
  context.connect = [channel = options.channel](const std::string& token) {
    return procgen_client::Client::FromChannel(channel, token, kCallTimeout);
  };
  context.report_episodes = options.report_episodes;
  context.pause_pool = options.pause_pool;
  context.feed = feed;
  context.watch_threads = watch_threads;
  context.differences = differences;
  return context;
}

std::vector<std::string> HostsOf(const WebOptions& options, const Address& address) {
  std::vector<std::string> hosts = options.allowed_hosts;
  hosts.push_back(address.host);
  return hosts;
}

class BeastServer final : public WebServer {
 public:
  BeastServer(const WebOptions& options, const Address& address, std::unique_ptr<Listener> listener)
      : url_(UrlOf(address, listener->port(), options.tls != nullptr)),
        site_(HostsOf(options, address), EmbeddedPages()),
        tls_(options.tls),
        feed_(std::make_unique<PoolFeed>(options.report_pools)),
        watch_threads_(
            std::make_unique<ThreadGroup>(static_cast<size_t>(options.viewers_max) * kWatchesMax,
                                          "the server has no room for another watch")),
        page_session_context_(
            PageSessionContextOf(options, feed_.get(), watch_threads_.get(), &differences_)),
        page_session_threads_(std::make_unique<ThreadGroup>(
            static_cast<size_t>(options.viewers_max),
            absl::StrCat("the server has no room for another page, --web_viewers_max is ",
                         options.viewers_max))),
        stub_(options.make_stub()),
        connection_context_{&site_,
                            {&page_session_context_, page_session_threads_.get()},
                            &bridge_context_,
                            &sockets_},
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
    sockets_.AwaitClosed(kCloseTimeout);
    io_.stop();
    for (std::thread& thread : io_threads_) {
      thread.join();
    }
    stub_.reset();                  // waits for the calls of the sockets, which have cancelled them
    page_session_threads_.reset();  // all were stopped; messages that they still send are dropped
    watch_threads_.reset();
    feed_.reset();
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
    StartConnection(std::move(socket), tls_.Current(), connection_context_);
  }

  const std::string url_;
  const Site site_;
  TlsContexts tls_;  // used only by the listener's thread
  DifferenceCache differences_;
  std::unique_ptr<PoolFeed> feed_;
  std::unique_ptr<ThreadGroup> watch_threads_;
  const PageSessionContext page_session_context_;
  std::unique_ptr<ThreadGroup> page_session_threads_;
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
  absl::StatusOr<std::unique_ptr<Listener>> listener =
      Listener::Listen(*address, options.viewers_max + kOtherConnectionsMax);
  if (!listener.ok()) {
    return absl::UnavailableError(
        absl::StrCat("cannot serve pages at ", options.address, ": ", listener.status().message()));
  }
  return std::make_unique<BeastServer>(options, *address, *std::move(listener));
}

}  // namespace procgen::web
