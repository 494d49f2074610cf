#ifndef SERVER_ENCODING_CHECK_H_
#define SERVER_ENCODING_CHECK_H_

#include <cstdio>
#include <cstdlib>

namespace procgen {

// Ends the process if a condition is false: a bug of the caller or of a library, or out of memory.
inline void Check(bool holds, const char* claim) {
  if (!holds) {
    std::fprintf(stderr, "procgen encoding: broken: %s\n", claim);
    std::abort();
  }
}

}  // namespace procgen

#endif  // SERVER_ENCODING_CHECK_H_
