#ifndef CLIENTS_TOP_TERMINAL_H_
#define CLIENTS_TOP_TERMINAL_H_

#include <termios.h>

#include <cstddef>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "clients/top/screen.h"

namespace procgen_top {

// SGR parameters (ECMA-48) of a style; empty for none.
const char* SgrOf(Style style, bool uses_color);
// A line with its style as escape sequences.
std::string StyledText(const Line& line, bool uses_color);

// The terminal of this process, with its alternate screen and with keys that arrive at once.
// Restores it at the end. SIGINT, SIGTERM and SIGWINCH must be blocked in all threads.
// Threads: compatible (one thread at a time).
class Terminal {
 public:
  explicit Terminal(bool uses_color);
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  // Waits for keys, a signal or a new size of the window.
  void Wait(absl::Duration timeout);
  // Returns the keys pressed since the last call. Arrows and other keys of the cursor are the
  // letters of less(1): j and k, b and space, g and G.
  std::string TakeKeys();
  // Whether q was pressed or a signal arrived that ends the program.
  bool is_ending() const { return is_ending_; }

  // Rows of the window.
  static size_t Height();
  // Shows lines, cut to the window.
  void Show(const std::vector<Line>& lines) const;

 private:
  void ReadKeys();
  void ReadSignal();

  const bool uses_color_;
  termios before_ = {};
  bool has_keys_ = false;  // standard input is a terminal
  int signals_ = -1;       // file descriptor
  bool is_ending_ = false;
  std::string keys_;
};

}  // namespace procgen_top

#endif  // CLIENTS_TOP_TERMINAL_H_
