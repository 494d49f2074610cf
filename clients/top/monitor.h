#ifndef CLIENTS_TOP_MONITOR_H_
#define CLIENTS_TOP_MONITOR_H_

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "clients/top/pool_table.h"
#include "clients/top/rate_history.h"
#include "clients/top/sample.h"
#include "clients/top/screen.h"
#include "procgen_client/client.h"

namespace procgen_top {

// What the program shows: the last two samples of a server, sorted and scrolled. If the server does
// not answer, the last screen stays, marked as outdated.
// Threads: compatible (one thread at a time).
class Monitor {
 public:
  // `address`: of the server, for the title.
  Monitor(procgen_client::Client* client, std::string address, PoolTableOptions options)
      : client_(client), address_(std::move(address)), options_(options) {}

  // Takes a sample. Errors: those of the server.
  absl::Status Update();
  // Applies keys of the keyboard, see README.md. `height`: of the window, in lines.
  void Press(const std::string& keys, size_t height);

  // All lines, for a file. REQUIRES: a successful update; rates are 0 before the second one.
  std::vector<Line> Lines() const;
  // The lines that fit a window, the last of which explains the keys. REQUIRES: as Lines.
  std::vector<Line> Window(size_t height);

 private:
  Screen CurrentScreen() const;
  void Scroll(char key, size_t page);

  procgen_client::Client* const client_;
  const std::string address_;
  PoolTableOptions options_;
  std::string title_;
  Sample before_;
  Sample now_;
  RateHistory history_;
  absl::Status status_;  // of the last update
  size_t first_ = 0;     // the first pool of the window
};

}  // namespace procgen_top

#endif  // CLIENTS_TOP_MONITOR_H_
