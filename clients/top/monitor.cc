#include "clients/top/monitor.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "clients/top/text_table.h"

namespace procgen_top {
namespace {

absl::StatusOr<std::string> TitleOf(procgen_client::Client* client, const std::string& address) {
  const auto catalog = client->GetCatalog();
  if (!catalog.ok()) {
    return catalog.status();
  }
  return absl::StrCat("procgen-server ", catalog->server_version(), " at ", address);
}

// The line below the pools: which are shown, and the keys.
std::string FooterOf(const PoolTableOptions& options, size_t first, size_t shown, size_t count) {
  std::string keys;
  const char* sorted_by = "";
  for (const SortChoice& choice : SortChoices()) {
    absl::StrAppend(&keys, " ", std::string(1, choice.letter), " ", choice.name);
    sorted_by = choice.sort_key == options.sort_key ? choice.name : sorted_by;
  }
  return absl::StrFormat("%d-%d of %d by %s%s   q quit   sort:%s   i reverse",
                         shown == 0 ? 0 : first + 1, first + shown, count, sorted_by,
                         options.is_reversed ? ", reversed" : "", keys);
}

}  // namespace

absl::Status Monitor::Update() {
  if (title_.empty() || !status_.ok()) {  // the server may be another one
    absl::StatusOr<std::string> title = TitleOf(client_, address_);
    if (!title.ok()) {
      return status_ = title.status();
    }
    title_ = *std::move(title);
  }
  absl::StatusOr<Sample> now = TakeSample(client_);
  status_ = now.status();
  if (!now.ok()) {
    return status_;
  }
  const bool is_first = now_.time == absl::Time();
  before_ = std::exchange(now_, *std::move(now));
  if (is_first) {
    before_ = now_;
  } else {
    history_.Add(before_, now_);
  }
  return status_;
}

Screen Monitor::CurrentScreen() const {
  return ScreenOf(title_, before_, now_, history_, options_);
}

std::vector<Line> Monitor::Lines() const {
  Screen screen = CurrentScreen();
  std::move(screen.pools.begin(), screen.pools.end(), std::back_inserter(screen.head));
  return std::move(screen.head);
}

std::vector<Line> Monitor::Window(size_t height) {
  const Screen screen = CurrentScreen();
  std::vector<Line> lines = screen.head;
  const size_t room = std::max(height, lines.size() + 2) - lines.size() - 1;
  const size_t count = screen.pools.size();
  first_ = std::min(first_, count - std::min(count, room));
  const size_t shown = std::min(room, count - first_);
  const auto begin = screen.pools.begin() + static_cast<std::ptrdiff_t>(first_);
  lines.insert(lines.end(), begin, begin + static_cast<std::ptrdiff_t>(shown));
  lines.resize(screen.head.size() + room);
  if (!status_.ok()) {
    for (Line& line : lines) {
      line.style = Style::kOutdated;
    }
    lines.front() = {absl::StrFormat("%s   LOST at %s, trying again: %s", Shown(title_),
                                     absl::FormatTime("%H:%M:%S", now_.time, absl::LocalTimeZone()),
                                     Shown(std::string(status_.message()))),
                     Style::kWarning};
  }
  lines.push_back({FooterOf(options_, first_, shown, count), Style::kTableHead});
  return lines;
}

void Monitor::Press(const std::string& keys, size_t height) {
  const size_t head = CurrentScreen().head.size();
  for (const char key : keys) {
    for (const SortChoice& choice : SortChoices()) {
      options_.sort_key = choice.letter == key ? choice.sort_key : options_.sort_key;
    }
    options_.is_reversed = options_.is_reversed != (key == 'i');
    Scroll(key, std::max(height, head + 2) - head - 1);
  }
}

void Monitor::Scroll(char key, size_t page) {
  switch (key) {
    case 'j':
      ++first_;
      break;
    case 'k':
      first_ -= std::min<size_t>(first_, 1);
      break;
    case ' ':
      first_ += page;
      break;
    case 'b':
      first_ -= std::min(first_, page);
      break;
    case 'g':
      first_ = 0;
      break;
    case 'G':
      first_ = now_.pools.size();
      break;
    default:
      break;
  }
  first_ = std::min(first_, now_.pools.size() - std::min(now_.pools.size(), page));
}

}  // namespace procgen_top
