// Annotates gRPC's operations for ThreadSanitizer: the start of an operation happens before its
// completion. Debian's gRPC is built without the sanitizer and hands
// operations from thread to thread with atomics, so it would report races within each operation: in
// gRPC's own headers, which are compiled into our programs, and in the messages and reactors of
// ours.
//
// Linked into every program of the tsan preset, these definitions come before the library's and
// call them. All C++ operations of gRPC, including streams and callbacks, use them. The order is
// that of a tag, so two operations of which neither waits for the other still race.
//
// Between a client and a server in one process gRPC passes the memory of a message itself, so
// sending a message happens before reading it. (Otherwise the sanitizer sees a socket between
// them.)

#include <sanitizer/tsan_interface.h>

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <utility>

#include "grpc/byte_buffer.h"
#include "grpc/byte_buffer_reader.h"
#include "grpc/grpc.h"
#include "grpcpp/alarm.h"
#include "grpcpp/support/server_callback.h"
#include "tests/sanitizer/library_function.h"

namespace {

constexpr char kLibrary[] = "libgrpc.so.29";
constexpr char kCppLibrary[] = "libgrpc++.so.1.51";

// Represents the end of calls; a server waits for the last one before its destruction.
char calls_over = 0;

void AfterWait(const grpc_event& event) {
  if (event.type == GRPC_OP_COMPLETE) {
    __tsan_acquire(event.tag);
  }
}

// Calls `use` for the reference-counted slices of a message.
template <typename Use>
void ForEachShared(grpc_byte_buffer* message, Use use) {
  if (message == nullptr || message->type != GRPC_BB_RAW) {
    return;
  }
  const grpc_slice_buffer& slices = message->data.raw.slice_buffer;
  for (size_t i = 0; i < slices.count; ++i) {
    if (slices.slices[i].refcount != nullptr) {
      use(slices.slices[i].refcount);
    }
  }
}

}  // namespace

grpc_call_error grpc_call_start_batch(grpc_call* call, const grpc_op* ops, size_t nops, void* tag,
                                      void* reserved) {
  static auto* const next =
      procgen::LibraryFunction<decltype(grpc_call_start_batch)>(kLibrary, "grpc_call_start_batch");
  __tsan_release(tag);
  for (size_t i = 0; i < nops; ++i) {
    if (ops[i].op == GRPC_OP_SEND_MESSAGE) {
      ForEachShared(ops[i].data.send_message.send_message,
                    [](void* shared) { __tsan_release(shared); });
    }
  }
  return next(call, ops, nops, tag, reserved);
}

grpc_event grpc_completion_queue_next(grpc_completion_queue* cq, gpr_timespec deadline,
                                      void* reserved) {
  static auto* const next = procgen::LibraryFunction<decltype(grpc_completion_queue_next)>(
      kLibrary, "grpc_completion_queue_next");
  const grpc_event event = next(cq, deadline, reserved);
  AfterWait(event);
  return event;
}

grpc_event grpc_completion_queue_pluck(grpc_completion_queue* cq, void* tag, gpr_timespec deadline,
                                       void* reserved) {
  static auto* const next = procgen::LibraryFunction<decltype(grpc_completion_queue_pluck)>(
      kLibrary, "grpc_completion_queue_pluck");
  const grpc_event event = next(cq, tag, deadline, reserved);
  AfterWait(event);
  return event;
}

void grpc_call_unref(grpc_call* call) {
  static auto* const next =
      procgen::LibraryFunction<decltype(grpc_call_unref)>(kLibrary, "grpc_call_unref");
  __tsan_release(&calls_over);
  next(call);
}

void grpc_server_destroy(grpc_server* server) {
  static auto* const next =
      procgen::LibraryFunction<decltype(grpc_server_destroy)>(kLibrary, "grpc_server_destroy");
  next(server);
  __tsan_acquire(&calls_over);
}

int grpc_byte_buffer_reader_init(grpc_byte_buffer_reader* reader, grpc_byte_buffer* buffer) {
  static auto* const next = procgen::LibraryFunction<decltype(grpc_byte_buffer_reader_init)>(
      kLibrary, "grpc_byte_buffer_reader_init");
  ForEachShared(buffer, [](void* shared) { __tsan_acquire(shared); });
  return next(reader, buffer);
}

namespace grpc::internal {
namespace {

// Calls a reactor's OnCancel, and makes it happen before what the library does next: it counts the
// callback down, and the last callback calls OnDone.
class CancelledReactor final : public ServerReactor {
 public:
  CancelledReactor(ServerReactor* reactor, void* call) : reactor_(reactor), call_(call) {}

  void OnCancel() override {
    reactor_->OnCancel();
    __tsan_release(call_);
    delete this;
  }
  void OnDone() override {}

 private:
  ServerReactor* const reactor_;
  void* const call_;
};

}  // namespace

void ServerCallbackCall::CallOnCancel(ServerReactor* reactor) {
  static auto* const next = procgen::LibraryFunction<void(ServerCallbackCall*, ServerReactor*)>(
      kCppLibrary, "_ZN4grpc8internal18ServerCallbackCall12CallOnCancelEPNS0_13ServerReactorE");
  next(this, new CancelledReactor(reactor, this));
}

// Called after the last callback of a call on the server. The library counts callbacks down without
// the sanitizer's knowledge; the load and the acquire order this after all of them.
void ServerCallbackCall::ScheduleOnDone(bool inline_ondone) {
  static auto* const next = procgen::LibraryFunction<void(ServerCallbackCall*, bool)>(
      kCppLibrary, "_ZN4grpc8internal18ServerCallbackCall14ScheduleOnDoneEb");
  callbacks_outstanding_.load(std::memory_order_acquire);
  __tsan_acquire(this);
  next(this, inline_ondone);
}

}  // namespace grpc::internal

namespace grpc {
namespace {

// The callback of an alarm. Alarm and timer share it; the last one to release it destroys it, after
// the callback returned.
class AlarmCallback {
 public:
  explicit AlarmCallback(std::function<void(bool)> callback)
      : kept_(std::make_shared<Kept>(std::move(callback))) {}

  void operator()(bool expired) const {
    kept_->callback(expired);
    __tsan_release(kept_.get());
  }

 private:
  struct Kept {
    explicit Kept(std::function<void(bool)> what) : callback(std::move(what)) {}
    ~Kept() { __tsan_acquire(this); }

    std::function<void(bool)> callback;
  };

  std::shared_ptr<Kept> kept_;
};

}  // namespace

void Alarm::SetInternal(gpr_timespec deadline, std::function<void(bool)> f) {
  static auto* const next =
      procgen::LibraryFunction<void(Alarm*, gpr_timespec, std::function<void(bool)>)>(
          kCppLibrary, "_ZN4grpc5Alarm11SetInternalE12gpr_timespecSt8functionIFvbEE");
  next(this, deadline, AlarmCallback(std::move(f)));
}

}  // namespace grpc
