#include "server/shared_memory/mapping_guard.h"

#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>

namespace procgen {

// An element of a list that only grows. `begin` is 0 if it is unused, and is set last.
struct MappingGuard::Range {
  std::atomic<uintptr_t> begin = 0;
  std::atomic<uintptr_t> end = 0;
  std::atomic<bool> is_taken = true;
  std::atomic<bool> was_replaced = false;
  Range* next = nullptr;

  static std::atomic<Range*> first_;

  // Returns an unused range, or a new one.
  static Range* Take() {
    for (Range* range = first_; range != nullptr; range = range->next) {
      if (bool free = false; range->is_taken.compare_exchange_strong(free, true)) {
        return range;
      }
    }
    auto* const made = new Range;
    made->next = first_;
    while (!first_.compare_exchange_weak(made->next, made)) {
    }
    return made;
  }

  // Replaces the mapping that contains the address. Returns false if the address is not in a
  // guarded one. Called in a signal handler, so it makes one raw system call: ThreadSanitizer
  // treats libc's mmap as a write to the whole mapping.
  static bool Replace(uintptr_t address) {
    for (Range* range = first_; range != nullptr; range = range->next) {
      const uintptr_t begin = range->begin;
      const uintptr_t end = range->end;
      if (begin == 0 || address < begin || address >= end) {
        continue;
      }
      range->was_replaced = true;
      return syscall(SYS_mmap, begin, end - begin, PROT_READ | PROT_WRITE,
                     MAP_FIXED | MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != -1;
    }
    return false;
  }

  static struct sigaction before_;  // the previous handler

  static void OnBusError(int signal, siginfo_t* info, void* /*context*/) {
    const int error = errno;
    if (!Replace(reinterpret_cast<uintptr_t>(info->si_addr))) {
      sigaction(signal, &before_, nullptr);  // the access repeats and reaches that handler
    }
    errno = error;
  }

  static bool Install() {
    struct sigaction action = {};
    action.sa_sigaction = OnBusError;
    action.sa_flags = SA_SIGINFO;
    sigemptyset(&action.sa_mask);
    return sigaction(SIGBUS, &action, &before_) == 0;
  }
};

std::atomic<MappingGuard::Range*> MappingGuard::Range::first_ = nullptr;
struct sigaction MappingGuard::Range::before_ = {};

MappingGuard::MappingGuard(void* memory, size_t bytes) : range_(Range::Take()) {
  [[maybe_unused]] static const bool is_installed = Range::Install();
  range_->was_replaced = false;
  range_->end = reinterpret_cast<uintptr_t>(memory) + bytes;
  range_->begin = reinterpret_cast<uintptr_t>(memory);
}

MappingGuard::~MappingGuard() {
  range_->begin = 0;
  range_->is_taken = false;
}

bool MappingGuard::was_replaced() const { return range_->was_replaced; }

}  // namespace procgen
