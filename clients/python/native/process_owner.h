#ifndef CLIENTS_PYTHON_NATIVE_PROCESS_OWNER_H_
#define CLIENTS_PYTHON_NATIVE_PROCESS_OWNER_H_

#include <unistd.h>

namespace procgen_python {

// The process that made an object. gRPC does not survive a fork: in a child the threads of its core
// are missing, and its file descriptors are shared with the parent. So what gRPC has a part in is
// leaked there, not destroyed.
class ProcessOwner {
 public:
  bool is_this_process() const { return process_id_ == getpid(); }

 private:
  const pid_t process_id_ = getpid();
};

}  // namespace procgen_python

#endif  // CLIENTS_PYTHON_NATIVE_PROCESS_OWNER_H_
