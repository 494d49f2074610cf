#ifndef TESTS_FUZZ_PIECES_H_
#define TESTS_FUZZ_PIECES_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace procgen {

// Aborts with `claim` unless it holds.
void Require(bool holds, absl::string_view claim, const absl::Status& status = absl::OkStatus());

// Inputs are pieces in a row: two bytes of length, little-endian, and so many bytes, or as many as
// there are. A piece of the greatest length, 65535, has no bytes and is a mark.
struct Piece {
  bool is_mark = false;
  std::string bytes;
};
std::vector<Piece> PiecesOf(const uint8_t* bytes, size_t size);
// Pieces as an input. REQUIRES: each has less than 65535 bytes.
std::string InputOf(const std::vector<Piece>& pieces);

}  // namespace procgen

#endif  // TESTS_FUZZ_PIECES_H_
