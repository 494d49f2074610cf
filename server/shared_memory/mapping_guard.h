#ifndef SERVER_SHARED_MEMORY_MAPPING_GUARD_H_
#define SERVER_SHARED_MEMORY_MAPPING_GUARD_H_

#include <cstddef>

namespace procgen {

// Guards a mapping of a shared file against truncation. Touching a page beyond the file's end
// raises SIGBUS, which ends the process. With a guard, the signal handler replaces the mapping by
// zeroed private memory, and the access continues.
//
// The first guard installs a SIGBUS handler for the process; a SIGBUS elsewhere goes to the
// previous handler. Wayland compositors protect themselves in the same way.
// Threads: any method from any thread.
class MappingGuard {
 public:
  // `memory`, [bytes]: a writable mapping, page aligned. Unmap it after this is destroyed.
  MappingGuard(void* memory, size_t bytes);
  ~MappingGuard();
  MappingGuard(const MappingGuard&) = delete;
  MappingGuard& operator=(const MappingGuard&) = delete;

  // Whether the mapping was replaced: writes to it are no longer shared.
  bool was_replaced() const;

 private:
  struct Range;
  Range* const range_;  // never freed, as the handler may read it at any time; reused
};

}  // namespace procgen

#endif  // SERVER_SHARED_MEMORY_MAPPING_GUARD_H_
