#ifndef CLIENTS_C_CALL_GUARD_H_
#define CLIENTS_C_CALL_GUARD_H_

#include <sys/types.h>
#include <unistd.h>

#include <cstdint>
#include <exception>
#include <initializer_list>
#include <memory>
#include <new>
#include <string>

#include "absl/strings/string_view.h"
#include "clients/c/procgen.h"
#include "envcore/status/status.h"
#include "procgen_client/pool.h"

// What the functions of the C ABI have in common: errors, checks of pointers, and processes.
namespace procgen_client {

// The process that created an object. A forked child has none of its threads, so it cannot use or
// free it.
class ProcessOwner {
 public:
  bool is_this_process() const { return process_id_ == getpid(); }
  // Errors: FAILED_PRECONDITION this is another process. `object`: "pool".
  procgen::Status Check(absl::string_view object) const;

 private:
  pid_t process_id_ = getpid();
};

// The message of the last failed call of this thread.
const std::string& ErrorMessage();
// Stores the message and returns the code.
ProcgenCode Fail(const procgen::Status& status);

// Runs the body of an interface function, and turns its status, or an exception, into a code.
template <typename Body>
ProcgenCode Guard(const Body& body) noexcept {
  try {
    const procgen::Status status = body();
    return status.ok() ? PROCGEN_OK : Fail(status);
  } catch (const std::bad_alloc&) {
    return Fail(procgen::ResourceExhaustedError("out of memory"));
  } catch (const std::exception& error) {
    return Fail(procgen::InternalError(error.what()));
  }
}

procgen::Status CheckNotNull(const void* pointer, absl::string_view name);
// An array of `count` elements, whose length a message names `count_name`.
procgen::Status CheckArray(const void* array, absl::string_view name, int64_t count,
                           absl::string_view count_name);
// A struct that begins with its size, at `given`.
procgen::Status CheckStructSize(const size_t* given, absl::string_view name);
template <typename Struct>
procgen::Status CheckStruct(const Struct* given, absl::string_view name) {
  return CheckStructSize(given == nullptr ? nullptr : &given->struct_size, name);
}

procgen::Status FirstError(std::initializer_list<procgen::Status> statuses);

}  // namespace procgen_client

struct ProcgenPool {
  std::unique_ptr<procgen_client::Pool> pool;
  procgen_client::ProcessOwner owner = {};
};

namespace procgen_client {

// As Guard, for functions of a pool: `body` takes it.
template <typename Body>
ProcgenCode GuardPool(const ProcgenPool* pool, const Body& body) noexcept {
  return Guard([&]() -> procgen::Status {
    procgen::Status status = CheckNotNull(pool, "pool");
    if (status.ok()) {
      status = pool->owner.Check("pool");
    }
    return status.ok() ? procgen::Status(body(*pool->pool)) : status;
  });
}

}  // namespace procgen_client

#endif  // CLIENTS_C_CALL_GUARD_H_
