#ifndef CLIENTS_PYTHON_NATIVE_PROCESS_OWNER_H_
#define CLIENTS_PYTHON_NATIVE_PROCESS_OWNER_H_

#include <unistd.h>

#include <utility>

namespace procgen_python {

// The process that made an object. gRPC does not survive a fork: a child has none of its threads
// and shares its file descriptors with the parent. A child therefore leaks objects that use gRPC.
class ProcessOwner {
 public:
  bool is_this_process() const { return process_id_ == getpid(); }

 private:
  const pid_t process_id_ = getpid();
};

// Leaks an object that uses gRPC, in a child.
template <typename Object>
void Leak(Object object) {
  new Object(std::move(object));
}

}  // namespace procgen_python

#endif  // CLIENTS_PYTHON_NATIVE_PROCESS_OWNER_H_
