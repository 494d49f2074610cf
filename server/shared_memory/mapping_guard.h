#ifndef SERVER_SHARED_MEMORY_MAPPING_GUARD_H_
#define SERVER_SHARED_MEMORY_MAPPING_GUARD_H_

#include <cstddef>

namespace procgen {

// Guards a mapping of a shared file against truncation. To touch a page that the file no longer has
// is a SIGBUS, which ends the process; with a guard the mapping is replaced, there and then, by
// zeroed memory of this process alone, and whoever touched it goes on.
//
// The first guard installs a handler of SIGBUS for the process; a SIGBUS elsewhere goes to the
// handler that was there before. Wayland compositors protect themselves in the same way. Threads:
// any method from any thread.
class MappingGuard {
 public:
  // `memory`, [bytes]: mapped with write access from a page's begin on; unmapped after this has
  // ended.
  MappingGuard(void* memory, size_t bytes);
  ~MappingGuard();
  MappingGuard(const MappingGuard&) = delete;
  MappingGuard& operator=(const MappingGuard&) = delete;

  // Whether the mapping was replaced: nobody else sees what is written to it.
  bool was_replaced() const;

 private:
  struct Range;
  Range* const range_;  // never freed, as a handler may look at it at any time; used again
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_MAPPING_GUARD_H_
