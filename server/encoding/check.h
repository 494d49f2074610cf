#ifndef SERVER_ENCODING_CHECK_H_
#define SERVER_ENCODING_CHECK_H_

#include <cstdio>
#include <cstdlib>

namespace procgen {

// Ends the process where what must hold does not: a bug of the caller or of a library, or no
// memory.
inline void Check(bool holds, const char* claim) {
  if (!holds) {
    std::fprintf(stderr, "procgen encoding: broken: %s\n", claim);
    std::abort();
  }
}

}  // namespace procgen

#endif  // SERVER_ENCODING_CHECK_H_
