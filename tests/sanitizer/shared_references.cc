// Annotates reference counts for ThreadSanitizer: every release of a reference happens before the
// last one. absl::Status, absl::Cord and the slices of gRPC's buffers count their references with
// atomics inside of Debian's libraries, which are built without the sanitizer.
//
// Linked into every program of the tsan preset, these definitions come before the library's and
// call them.

#include <sanitizer/tsan_interface.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>

#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "grpc/byte_buffer.h"
#include "grpc/slice.h"
#include "tests/sanitizer/library_function.h"

namespace {

constexpr char kStatusLibrary[] = "libabsl_status.so.20220623";
constexpr char kCordLibrary[] = "libabsl_cord.so.20220623";
constexpr char kGrpcLibrary[] = "libgrpc.so.29";

// `shared`: the address of the counted object; null: not counted.
void LetGo(void* shared) {
  if (shared != nullptr) {
    __tsan_release(shared);
    __tsan_acquire(shared);
  }
}

// Serialises releases, so that the release annotated as the last one is the last. Relaxed, because
// the sanitizer must not see any other ordering. Freed objects may contain slices.
class LettingGo {
 public:
  LettingGo() {
    if (depth_++ == 0) {
      while (taken_.exchange(true, std::memory_order_relaxed)) {
        std::this_thread::yield();
      }
    }
  }
  ~LettingGo() {
    if (--depth_ == 0) {
      taken_.store(false, std::memory_order_relaxed);
    }
  }
  LettingGo(const LettingGo&) = delete;
  LettingGo& operator=(const LettingGo&) = delete;

 private:
  static inline std::atomic<bool> taken_ = false;
  static inline thread_local int depth_ = 0;
};

}  // namespace

namespace absl {
ABSL_NAMESPACE_BEGIN

void Status::UnrefNonInlined(uintptr_t rep) {
  static auto* const next = procgen::LibraryFunction<void(uintptr_t)>(
      kStatusLibrary, "_ZN4absl7debian36Status15UnrefNonInlinedEm");
  LetGo(reinterpret_cast<void*>(rep));
  next(rep);
}

void Cord::DestroyCordSlow() {
  static auto* const next = procgen::LibraryFunction<void(Cord*)>(
      kCordLibrary, "_ZN4absl7debian34Cord15DestroyCordSlowEv");
  const LettingGo turn;
  LetGo(contents_.tree());
  next(this);
}

ABSL_NAMESPACE_END
}  // namespace absl

void grpc_slice_unref(grpc_slice slice) {
  static auto* const next =
      procgen::LibraryFunction<decltype(grpc_slice_unref)>(kGrpcLibrary, "grpc_slice_unref");
  const LettingGo turn;
  LetGo(slice.refcount);
  next(slice);
}

void grpc_byte_buffer_destroy(grpc_byte_buffer* buffer) {
  static auto* const next = procgen::LibraryFunction<decltype(grpc_byte_buffer_destroy)>(
      kGrpcLibrary, "grpc_byte_buffer_destroy");
  const LettingGo turn;
  if (buffer != nullptr && buffer->type == GRPC_BB_RAW) {
    const grpc_slice_buffer& slices = buffer->data.raw.slice_buffer;
    for (size_t i = 0; i < slices.count; ++i) {
      LetGo(slices.slices[i].refcount);
    }
  }
  next(buffer);
}
