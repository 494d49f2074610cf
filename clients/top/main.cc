// procgen-top: monitors a running server in a terminal. `procgen-top --help` lists the flags;
// README.md explains the screen.

#include <sys/ioctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "absl/time/time.h"
#include "clients/top/sample.h"
#include "clients/top/screen.h"
#include "procgen_client/client.h"

ABSL_FLAG(std::string, server, "127.0.0.1:50051", "address of the server: HOST:PORT or unix:PATH");
ABSL_FLAG(absl::Duration, interval, absl::Seconds(1),
          "time between two updates, 100ms to 1h; rates and latencies are of this time");
ABSL_FLAG(bool, once, false, "print one screen, for one interval, and exit");
ABSL_FLAG(std::string, delete, "", "delete this pool (ID or pools/ID) and exit");

namespace procgen_top {
namespace {

constexpr int kExitUsage = 2;

// Uses the terminal's alternate screen while it exists, and restores the terminal at its end.
class Terminal {
 public:
  Terminal() { Write("\x1b[?1049h\x1b[?25l"); }
  ~Terminal() { Write("\x1b[?25h\x1b[?1049l"); }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  // Shows lines, cut to the size of the terminal.
  static void Show(const std::vector<std::string>& lines) {
    winsize size = {};
    ioctl(STDOUT_FILENO, TIOCGWINSZ, &size);
    std::string text = "\x1b[H";
    for (size_t i = 0; i < lines.size() && (size.ws_row == 0 || i + 1 < size.ws_row); ++i) {
      const size_t width = size.ws_col == 0 ? lines[i].size() : size.ws_col;
      absl::StrAppend(&text, lines[i].substr(0, width), "\x1b[K\r\n");
    }
    Write(text + "\x1b[J");
  }

 private:
  static void Write(const std::string& text) {
    std::fputs(text.c_str(), stdout);
    std::fflush(stdout);
  }
};

void Print(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    std::puts(line.c_str());
  }
  std::fflush(stdout);
}

sigset_t StopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

// Waits. Returns false if a stop signal arrives.
bool Wait(absl::Duration interval) {
  const sigset_t signals = StopSignals();
  const timespec time = absl::ToTimespec(interval);
  return sigtimedwait(&signals, nullptr, &time) < 0;
}

int Fail(const absl::Status& status) {
  std::fprintf(stderr, "procgen-top: %s\n", std::string(status.message()).c_str());
  return 1;
}

absl::StatusOr<std::string> TitleOf(procgen_client::Client* client) {
  const auto catalog = client->GetCatalog();
  if (!catalog.ok()) {
    return catalog.status();
  }
  return absl::StrCat("procgen-server ", catalog->server_version(), " at ",
                      absl::GetFlag(FLAGS_server));
}

// Shows screens until a stop signal. Shows an error of the server, and retries in the next
// interval.
void ShowUntilStopped(procgen_client::Client* client, const std::string& title, Sample before) {
  const bool on_terminal = isatty(STDOUT_FILENO) != 0;
  const std::unique_ptr<Terminal> terminal = on_terminal ? std::make_unique<Terminal>() : nullptr;
  while (Wait(absl::GetFlag(FLAGS_interval))) {
    absl::StatusOr<Sample> now = TakeSample(client);
    const std::vector<std::string> lines =
        now.ok() ? ScreenOf(title, before, *now)
                 : std::vector<std::string>{title, std::string(now.status().message())};
    if (on_terminal) {
      Terminal::Show(lines);
    } else {
      Print(lines);
      std::puts("");
    }
    if (now.ok()) {
      before = *std::move(now);
    }
  }
}

int Delete(procgen_client::Client* client, absl::string_view pool) {
  const std::string name = absl::StrCat("pools/", absl::StripPrefix(pool, "pools/"));
  if (const absl::Status status = client->DeletePool(name); !status.ok()) {
    return Fail(status);
  }
  std::printf("deleted %s\n", name.c_str());
  return 0;
}

int Show() {
  auto client = procgen_client::Client::Connect(absl::GetFlag(FLAGS_server));
  if (!client.ok()) {
    return Fail(client.status());
  }
  if (const std::string pool = absl::GetFlag(FLAGS_delete); !pool.empty()) {
    return Delete(client->get(), pool);
  }
  const absl::StatusOr<std::string> title = TitleOf(client->get());
  if (!title.ok()) {
    return Fail(title.status());
  }
  absl::StatusOr<Sample> first = TakeSample(client->get());
  if (!first.ok()) {
    return Fail(first.status());
  }
  if (!absl::GetFlag(FLAGS_once)) {
    ShowUntilStopped(client->get(), *title, *std::move(first));
    return 0;
  }
  if (!Wait(absl::GetFlag(FLAGS_interval))) {
    return 0;
  }
  const absl::StatusOr<Sample> now = TakeSample(client->get());
  if (!now.ok()) {
    return Fail(now.status());
  }
  Print(ScreenOf(*title, *first, *now));
  return 0;
}

int Main(int argc, char** argv) {
  // Blocked in all threads and received between two screens, so that no handler has to restore the
  // terminal.
  const sigset_t signals = StopSignals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  absl::SetProgramUsageMessage("monitors a running procgen-server in a terminal");
  if (const std::vector<char*> rest = absl::ParseCommandLine(argc, argv); rest.size() > 1) {
    std::fprintf(stderr, "procgen-top: '%s' is not a flag; see --help\n", rest[1]);
    return kExitUsage;
  }
  if (const absl::Duration interval = absl::GetFlag(FLAGS_interval);
      interval < absl::Milliseconds(100) || interval > absl::Hours(1)) {
    std::fprintf(stderr, "procgen-top: --interval is %s, allowed: 100ms to 1h\n",
                 absl::FormatDuration(interval).c_str());
    return kExitUsage;
  }
  return Show();
}

}  // namespace
}  // namespace procgen_top

int main(int argc, char** argv) { return procgen_top::Main(argc, argv); }
