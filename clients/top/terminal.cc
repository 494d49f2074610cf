#include "clients/top/terminal.h"

#include <poll.h>
#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "clients/top/text_table.h"

namespace procgen_top {
namespace {

void Write(absl::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

winsize SizeOfWindow() {
  winsize size = {};
  ioctl(STDOUT_FILENO, TIOCGWINSZ, &size);
  // A terminal without a size, as of a serial line, has the traditional one.
  constexpr decltype(size.ws_row) kRows = 24;
  constexpr decltype(size.ws_col) kColumns = 80;
  size.ws_row = size.ws_row == 0 ? kRows : size.ws_row;
  size.ws_col = size.ws_col == 0 ? kColumns : size.ws_col;
  return size;
}

// Replaces the sequences of cursor keys by letters.
std::string LettersOf(absl::string_view keys) {
  return absl::StrReplaceAll(keys, {{"\x1b[A", "k"},
                                    {"\x1bOA", "k"},
                                    {"\x1b[B", "j"},
                                    {"\x1bOB", "j"},
                                    {"\x1b[5~", "b"},
                                    {"\x1b[6~", " "},
                                    {"\x1b[H", "g"},
                                    {"\x1b[1~", "g"},
                                    {"\x1b[F", "G"},
                                    {"\x1b[4~", "G"}});
}

}  // namespace

const char* SgrOf(Style style, bool uses_color) {
  switch (style) {
    case Style::kPlain:
      return "";
    case Style::kTitle:
      return uses_color ? "1;36" : "1";
    case Style::kTableHead:
      return uses_color ? "30;42" : "7";
    case Style::kWarning:
      return uses_color ? "1;37;41" : "1;7";
    case Style::kOutdated:
      return "2";
  }
  return "";
}

std::string StyledText(const Line& line, bool uses_color) {
  const absl::string_view sgr = SgrOf(line.style, uses_color);
  return sgr.empty() ? line.text : absl::StrCat("\x1b[", sgr, "m", line.text, "\x1b[0m");
}

Terminal::Terminal(bool uses_color) : uses_color_(uses_color) {
  has_keys_ = tcgetattr(STDIN_FILENO, &before_) == 0;
  if (has_keys_) {
    termios at_once = before_;
    at_once.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    tcsetattr(STDIN_FILENO, TCSANOW, &at_once);
  }
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGWINCH}) {
    sigaddset(&signals, signal);
  }
  signals_ = signalfd(-1, &signals, SFD_CLOEXEC);
  Write("\x1b[?1049h\x1b[?25l");
}

Terminal::~Terminal() {
  Write("\x1b[?25h\x1b[?1049l");
  close(signals_);
  if (has_keys_) {
    tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
}

void Terminal::Wait(absl::Duration timeout) {
  std::array<pollfd, 2> waits = {{{signals_, POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}}};
  const timespec time = absl::ToTimespec(std::max(timeout, absl::ZeroDuration()));
  if (ppoll(waits.data(), has_keys_ ? 2 : 1, &time, nullptr) <= 0) {
    return;
  }
  if (waits[0].revents != 0) {
    ReadSignal();
  }
  if (waits[1].revents != 0) {
    ReadKeys();
  }
}

void Terminal::ReadSignal() {
  signalfd_siginfo signal = {};
  if (read(signals_, &signal, sizeof(signal)) == sizeof(signal)) {
    is_ending_ = is_ending_ || signal.ssi_signo != SIGWINCH;
  }
}

void Terminal::ReadKeys() {
  std::array<char, 64> bytes = {};
  const ssize_t count = read(STDIN_FILENO, bytes.data(), bytes.size());
  if (count <= 0) {
    is_ending_ = true;  // the terminal is gone
    return;
  }
  const std::string keys = LettersOf({bytes.data(), static_cast<size_t>(count)});
  is_ending_ = is_ending_ || keys.find('q') != std::string::npos;
  keys_ += keys;
}

std::string Terminal::TakeKeys() { return std::exchange(keys_, ""); }

size_t Terminal::Height() { return SizeOfWindow().ws_row; }

void Terminal::Show(const std::vector<Line>& lines) const {
  const winsize size = SizeOfWindow();
  std::string text = "\x1b[H";
  for (size_t i = 0; i < lines.size() && i < size.ws_row; ++i) {
    std::string shown(FirstCharacters(lines[i].text, size.ws_col));
    if (lines[i].style == Style::kTableHead) {  // a bar over the whole window
      shown.append(size.ws_col - std::min<size_t>(size.ws_col, shown.size()), ' ');
    }
    absl::StrAppend(&text, i == 0 ? "" : "\r\n", StyledText({shown, lines[i].style}, uses_color_),
                    "\x1b[K");
  }
  Write(absl::StrCat(text, "\x1b[J"));
}

}  // namespace procgen_top
