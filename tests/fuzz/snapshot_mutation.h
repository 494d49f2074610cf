#ifndef TESTS_FUZZ_SNAPSHOT_MUTATION_H_
#define TESTS_FUZZ_SNAPSHOT_MUTATION_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace procgen {

// Returns `snapshot` with one to four changes to the tree of its body, drawn by `seed`. A change
// sets a number (to a near value, an extreme one, or a kind of cell or entity), copies the value of
// another field, flips a boolean, removes, duplicates, multiplies or moves an entry of a list, or
// removes a field. Corrects length and checksum. Returns an empty string if `snapshot` is invalid,
// or if the result would be longer than `length_max` bytes. Threads: any.
std::string MutatedSnapshot(absl::string_view snapshot, uint32_t seed, size_t length_max);

}  // namespace procgen

#endif  // TESTS_FUZZ_SNAPSHOT_MUTATION_H_
