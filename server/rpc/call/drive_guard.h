#ifndef SERVER_RPC_CALL_DRIVE_GUARD_H_
#define SERVER_RPC_CALL_DRIVE_GUARD_H_

namespace procgen {

// Detects nested calls of a stream's Drive, which must return immediately: the running loop handles
// the events that occur within its actions. A nested loop would deepen the stack with each request.
class DriveGuard {
 public:
  // `stream`: whose Drive this is.
  explicit DriveGuard(const void* stream) : outer_(driven_), is_nested_(driven_ == stream) {
    driven_ = stream;
  }
  ~DriveGuard() { driven_ = outer_; }
  DriveGuard(const DriveGuard&) = delete;
  DriveGuard& operator=(const DriveGuard&) = delete;

  bool is_nested() const { return is_nested_; }

 private:
  inline static thread_local const void* driven_ = nullptr;  // by this thread

  const void* const outer_;
  const bool is_nested_;
};

}  // namespace procgen

#endif  // SERVER_RPC_CALL_DRIVE_GUARD_H_
