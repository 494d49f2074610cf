// procgen-top: monitors a running server in a terminal. `procgen-top --help` lists the flags;
// README.md explains the screen.

#include <langinfo.h>
#include <unistd.h>

#include <clocale>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "absl/flags/flag.h"
#include "absl/flags/parse.h"
#include "absl/flags/usage.h"
#include "absl/flags/usage_config.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "clients/top/monitor.h"
#include "clients/top/terminal.h"
#include "procgen_client/client.h"

ABSL_FLAG(std::string, server, "127.0.0.1:50051", "address of the server: HOST:PORT or unix:PATH");
ABSL_FLAG(absl::Duration, interval, absl::Seconds(1),
          "time between two updates, 100ms to 1h; rates and latencies are of this time");
ABSL_FLAG(std::string, sort, "steps",
          "what the pools are sorted by: steps (per second), return, length, latency, age or name");
ABSL_FLAG(std::string, color, "auto",
          "auto: on a terminal, unless the environment variable NO_COLOR is set; always; never");
ABSL_FLAG(bool, once, false, "print one screen, for one interval, and exit");
ABSL_FLAG(std::string, delete, "", "delete this pool (ID or pools/ID) and exit");

namespace procgen_top {
namespace {

constexpr int kExitUsage = 2;

// A server that does not answer for this long is reported.
constexpr absl::Duration kAnswerTimeout = absl::Seconds(2);

const sigset_t& Signals() {
  static const sigset_t signals = [] {
    sigset_t set;
    sigemptyset(&set);
    for (const int signal : {SIGINT, SIGTERM, SIGWINCH}) {
      sigaddset(&set, signal);
    }
    return set;
  }();
  return signals;
}

bool UsesColor() {
  const std::string color = absl::GetFlag(FLAGS_color);
  if (color != "auto") {
    return color == "always";
  }
  const char* no_color = std::getenv("NO_COLOR");
  return isatty(STDOUT_FILENO) != 0 && (no_color == nullptr || *no_color == '\0');
}

void Print(const std::vector<Line>& lines) {
  const bool is_styled = absl::GetFlag(FLAGS_color) == "always";
  for (const Line& line : lines) {
    std::puts((is_styled ? StyledText(line, true) : line.text).c_str());
  }
  std::fflush(stdout);
}

// Waits. Returns false if a stop signal arrives.
bool Wait(absl::Duration interval) {
  const timespec time = absl::ToTimespec(interval);
  int signal = 0;
  while ((signal = sigtimedwait(&Signals(), nullptr, &time)) == SIGWINCH) {
  }
  return signal < 0;
}

int Fail(const absl::Status& status) {
  std::fprintf(stderr, "procgen-top: %s\n", std::string(status.message()).c_str());
  return 1;
}

// Shows the server until q is pressed or a stop signal arrives. An update in progress ends, too.
void ShowOnTerminal(Monitor* monitor, Terminal* terminal) {
  const absl::Duration interval = absl::GetFlag(FLAGS_interval);
  absl::Time next = absl::Now() + interval;
  bool has_rates = false;
  while (!terminal->is_ending()) {
    terminal->Wait(next - absl::Now());
    monitor->Press(terminal->TakeKeys(), Terminal::Height());
    if (absl::Now() >= next) {
      monitor->Update().IgnoreError();  // the window shows the error
      next = absl::Now() + interval;
      has_rates = true;
    }
    if (has_rates) {
      terminal->Show(monitor->Window(Terminal::Height()));
    }
  }
}

// Prints screens until a stop signal arrives; the first error ends `--once`.
int PrintScreens(Monitor* monitor) {
  while (Wait(absl::GetFlag(FLAGS_interval))) {
    const absl::Status status = monitor->Update();
    if (status.ok()) {
      Print(monitor->Lines());
    } else if (absl::GetFlag(FLAGS_once)) {
      return Fail(status);
    } else {
      Print({{std::string(status.message()), Style::kWarning}});
    }
    if (absl::GetFlag(FLAGS_once)) {
      break;
    }
    std::puts("");
  }
  return 0;
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
  std::unique_ptr<Terminal> terminal;  // null: not yet, or the output is no terminal
  procgen_client::ConnectOptions options;
  options.timeout = kAnswerTimeout;
  options.call_timeout = kAnswerTimeout;
  options.is_cancelled = [&terminal] {
    if (terminal != nullptr) {
      terminal->Wait(absl::ZeroDuration());
    }
    return terminal != nullptr && terminal->is_ending();
  };
  const auto client = procgen_client::Client::Connect(absl::GetFlag(FLAGS_server), options);
  if (!client.ok()) {
    return Fail(client.status());
  }
  if (const std::string pool = absl::GetFlag(FLAGS_delete); !pool.empty()) {
    return Delete(client->get(), pool);
  }
  const bool is_utf8 = std::strcmp(nl_langinfo(CODESET), "UTF-8") == 0;
  Monitor monitor(client->get(), absl::GetFlag(FLAGS_server),
                  {*SortKeyOf(absl::GetFlag(FLAGS_sort)), false, is_utf8});
  if (const absl::Status status = monitor.Update(); !status.ok()) {
    return Fail(status);
  }
  if (absl::GetFlag(FLAGS_once) || isatty(STDOUT_FILENO) == 0) {
    return PrintScreens(&monitor);
  }
  terminal = std::make_unique<Terminal>(UsesColor());
  ShowOnTerminal(&monitor, terminal.get());
  return 0;
}

// Returns a message about a wrong flag, empty if there is none.
std::string FlagError() {
  const absl::Duration interval = absl::GetFlag(FLAGS_interval);
  if (interval < absl::Milliseconds(100) || interval > absl::Hours(1)) {
    return absl::StrCat("--interval is ", absl::FormatDuration(interval), ", allowed: 100ms to 1h");
  }
  if (!SortKeyOf(absl::GetFlag(FLAGS_sort)).has_value()) {
    return absl::StrCat("--sort is '", absl::GetFlag(FLAGS_sort),
                        "', allowed: steps, return, length, latency, age, name");
  }
  const std::string color = absl::GetFlag(FLAGS_color);
  if (color != "auto" && color != "always" && color != "never") {
    return absl::StrCat("--color is '", color, "', allowed: auto, always, never");
  }
  return "";
}

int Main(int argc, char** argv) {
  // Blocked in all threads and received between two screens, so that no handler has to restore the
  // terminal.
  pthread_sigmask(SIG_BLOCK, &Signals(), nullptr);
  std::setlocale(LC_CTYPE, "");
  const auto is_ours = [](absl::string_view file) {
    return absl::EndsWith(file, "clients/top/main.cc");
  };
  absl::FlagsUsageConfig usage;
  usage.contains_help_flags = is_ours;
  usage.contains_helpshort_flags = is_ours;
  absl::SetFlagsUsageConfig(usage);
  absl::SetProgramUsageMessage("monitors a running procgen-server in a terminal");
  if (const std::vector<char*> rest = absl::ParseCommandLine(argc, argv); rest.size() > 1) {
    std::fprintf(stderr, "procgen-top: '%s' is not a flag; see --help\n", rest[1]);
    return kExitUsage;
  }
  if (const std::string error = FlagError(); !error.empty()) {
    std::fprintf(stderr, "procgen-top: %s\n", error.c_str());
    return kExitUsage;
  }
  return Show();
}

}  // namespace
}  // namespace procgen_top

int main(int argc, char** argv) { return procgen_top::Main(argc, argv); }
