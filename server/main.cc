// procgen-server: hosts pools of Procgen environments behind a gRPC API. `procgen-server --help`
// explains the flags.

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/flags/usage_config.h"
#include "absl/status/statusor.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/synchronization/mutex.h"
#include "server/config.h"
#include "server/flags.h"
#include "server/logging/event_log.h"
#include "server/metrics/metrics_page.h"
#include "server/net/address.h"
#include "server/net/listener.h"
#include "server/rpc/server.h"
#include "server/web/web_server.h"

namespace procgen {
namespace {

constexpr int kExitFailedToStart = 1;
constexpr int kExitUsage = 2;
// Time for running requests to be answered after a signal to stop.
constexpr absl::Duration kDrainTimeout = absl::Seconds(1);
// How long a process that exits waits for its log lines to be written.
constexpr absl::Duration kLogTimeout = absl::Seconds(1);

// The signals that stop the server. Blocked in all threads; Serve waits for them, without a
// handler.
sigset_t StopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  return signals;
}

// The access control as text for the log.
std::string AccessText(const Config& config) {
  return absl::StrCat(config.server.tls == nullptr                       ? "plain text"
                      : config.server.tls->requires_client_certificate() ? "mutual TLS"
                                                                         : "TLS",
                      config.server.tokens == nullptr ? "" : ", tokens");
}

// Returns null if no metrics address is configured.
absl::StatusOr<std::unique_ptr<MetricsPage>> StartMetricsPage(const Config& config,
                                                              const Server& server) {
  if (config.metrics_address.empty()) {
    return nullptr;
  }
  absl::StatusOr<std::unique_ptr<MetricsPage>> page =
      MetricsPage::Start(config.metrics_address, server.metrics());
  // The library of the page reports no reason. Listening reports it.
  if (const absl::Status reason =
          page.ok() ? page.status()
                    : Listener::Listen(*ParseAddress(config.metrics_address)).status();
      !reason.ok()) {
    return absl::UnavailableError(absl::StrCat("metrics cannot be served at ",
                                               config.metrics_address, ": ", reason.message()));
  }
  return page;
}

// Returns null if no web address is configured.
absl::StatusOr<std::unique_ptr<web::WebServer>> StartWebServer(const Config& config,
                                                               const Server& server) {
  if (config.web_address.empty()) {
    return nullptr;
  }
  return web::WebServer::Start({.address = config.web_address,
                                .allowed_hosts = config.web_allowed_hosts,
                                .viewers_max = config.web_viewers_max,
                                .tls = config.server.tls,
                                .make_stub = [&server] { return server.MakeStub(); },
                                .request_bytes_max = config.server.limits.request_bytes_max});
}

int FailToStart(const absl::Status& status) {
  LogEvent(LogLevel::kError, "start_failed", {{"message", std::string(status.message())}});
  return kExitFailedToStart;
}

int Serve(const Config& config, const sigset_t& stop_signals) {
  SetLogLevel(config.log_level);
  absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(config.server);
  if (!server.ok()) {
    return FailToStart(server.status());
  }
  absl::StatusOr<std::unique_ptr<MetricsPage>> metrics_page = StartMetricsPage(config, **server);
  if (!metrics_page.ok()) {
    return FailToStart(metrics_page.status());
  }
  absl::StatusOr<std::unique_ptr<web::WebServer>> web_server = StartWebServer(config, **server);
  if (!web_server.ok()) {
    return FailToStart(web_server.status());
  }
  LogEvent(LogLevel::kInfo, "listening",
           {{"address", (*server)->address()},
            {"version", PROCGEN_SERVER_VERSION},
            {"workers", absl::StrCat(config.server.worker_count)},
            {"access", AccessText(config)},
            {"cluster", config.cluster.name.empty() ? "none" : config.cluster.name},
            {"node", config.cluster.node_id},
            {"metrics", *metrics_page == nullptr ? "none" : (*metrics_page)->address()},
            {"web", *web_server == nullptr ? "none" : (*web_server)->url()},
            {"art", config.art_dir.empty() ? "built-in" : config.art_dir}});
  FlushLog(kLogTimeout);  // readers of the line below may look into the log
  // The address for programs that start this one, printed once clients can connect.
  std::printf("listening on %s\n", (*server)->address().c_str());
  std::fflush(stdout);

  int signal = 0;
  sigwait(&stop_signals, &signal);
  LogEvent(LogLevel::kInfo, "draining", {{"signal", signal == SIGTERM ? "SIGTERM" : "SIGINT"}});
  if (*web_server != nullptr) {
    (*web_server)->BeginClose();
  }
  (*server)->Stop(kDrainTimeout);
  web_server->reset();    // now: Stop ends the calls that its pages wait for
  metrics_page->reset();  // last: it reads the server's metrics, also during a drain
  LogEvent(LogLevel::kInfo, "stopped", {});
  return 0;
}

bool AsksForHelp(absl::string_view argument) {
  absl::ConsumePrefix(&argument, "-");
  absl::ConsumePrefix(&argument, "-");
  return argument == "help" || argument == "helpfull" || argument == "helpshort" ||
         absl::StartsWith(argument, "help=");
}

// Parses the flags and returns the remaining arguments. Abseil ends the process with status 1 for
// an invalid flag and after --help; here the statuses are kExitUsage and 0.
std::vector<char*> ParseFlags(int argc, char** argv) {
  static bool is_parsing = false;
  static const bool asks_for_help = std::any_of(argv + 1, argv + argc, AsksForHelp);
  on_exit(
      [](int status, void* /*none*/) {
        if (is_parsing && status == 1) {
          std::fflush(nullptr);
          _exit(asks_for_help ? 0 : kExitUsage);
        }
      },
      nullptr);
  is_parsing = true;
  std::vector<char*> rest = absl::ParseCommandLine(argc, argv);
  is_parsing = false;
  return rest;
}

int Main(int argc, char** argv) {
  const sigset_t stop_signals = StopSignals();
  pthread_sigmask(SIG_BLOCK, &stop_signals, nullptr);
  // A write beyond the file size limit returns an error instead of ending the process.
  std::signal(SIGXFSZ, SIG_IGN);
  // The readers of the log and of standard output may exit.
  std::signal(SIGPIPE, SIG_IGN);
  // Debian's Abseil checks for deadlocks at every lock of a mutex, here and in gRPC. The tests keep
  // the check; here it would cost some percent of the time.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);

  const auto is_ours = [](absl::string_view file) {
    return absl::EndsWith(file, "server/flags.cc");
  };
  absl::FlagsUsageConfig usage;
  usage.contains_help_flags = is_ours;
  usage.contains_helpshort_flags = is_ours;
  usage.version_string = [] {
    return absl::StrCat("procgen-server ", PROCGEN_SERVER_VERSION, "\n");
  };
  absl::SetFlagsUsageConfig(usage);
  absl::SetProgramUsageMessage("hosts pools of Procgen environments behind gRPC");
  if (const std::vector<char*> rest = ParseFlags(argc, argv); rest.size() > 1) {
    std::fprintf(stderr, "procgen-server: '%s' is not a flag; see --help\n", rest[1]);
    return kExitUsage;
  }
  absl::StatusOr<Config> config = ReadFlags();
  absl::Status status = config.status();
  if (status.ok()) {
    status = JoinCluster(&*config);
  }
  if (!status.ok()) {
    FlushLog(kLogTimeout);
    std::fprintf(stderr, "procgen-server: %s\n", std::string(status.message()).c_str());
    return kExitUsage;
  }
  const int exit_status = Serve(*config, stop_signals);
  FlushLog(kLogTimeout);
  return exit_status;
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) { return procgen::Main(argc, argv); }
