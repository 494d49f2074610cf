#ifndef TESTS_FUZZ_SNAPSHOT_MUTATION_H_
#define TESTS_FUZZ_SNAPSHOT_MUTATION_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace procgen {

// `snapshot` with one to four changes to the tree of its body, drawn by `seed`: a number set to
// another one (near by, extreme, or a kind of cell or entity), a value of another field put in its
// place, a boolean turned, an entry of a list dropped, doubled, multiplied or moved, a field
// dropped. Its length and checksum are right again. Empty where `snapshot` is none, or the changed
// one would be longer than `length_max` bytes. Threads: any.
std::string MutatedSnapshot(absl::string_view snapshot, uint32_t seed, size_t length_max);

}  // namespace procgen

#endif  // TESTS_FUZZ_SNAPSHOT_MUTATION_H_
