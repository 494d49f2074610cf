#ifndef TESTS_FUZZ_PIECES_H_
#define TESTS_FUZZ_PIECES_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace procgen {

// Aborts with `claim` if `holds` is false.
void Require(bool holds, absl::string_view claim, const absl::Status& status = absl::OkStatus());

// An input is a sequence of pieces: two bytes of length, little-endian, and that many bytes, or the
// remaining bytes if there are fewer. A piece of length 65535 has no bytes and is a mark.
struct Piece {
  bool is_mark = false;
  std::string bytes;
};
std::vector<Piece> PiecesOf(const uint8_t* bytes, size_t size);

}  // namespace procgen

#endif  // TESTS_FUZZ_PIECES_H_
