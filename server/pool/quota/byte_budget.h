#ifndef SERVER_POOL_QUOTA_BYTE_BUDGET_H_
#define SERVER_POOL_QUOTA_BYTE_BUDGET_H_

#include <atomic>
#include <cstdint>

namespace procgen {

// A limit on memory shared by several users. Memory is reserved before it is used.
// Threads: any method from any thread; none blocks.
class ByteBudget {
 public:
  explicit ByteBudget(int64_t bytes_max) : bytes_max_(bytes_max) {}
  ByteBudget(const ByteBudget&) = delete;
  ByteBudget& operator=(const ByteBudget&) = delete;

  int64_t bytes_max() const { return bytes_max_; }
  int64_t reserved_bytes() const { return reserved_bytes_; }

  // Replaces a reservation of `from` bytes (0: none) by one of `to`. Returns false and changes
  // nothing if the budget is exceeded. A decrease always succeeds.
  bool Change(int64_t from, int64_t to) {
    int64_t before = reserved_bytes_;
    do {
      if (to > from && to - from > bytes_max_ - before) {
        return false;
      }
    } while (!reserved_bytes_.compare_exchange_weak(before, before + to - from));
    return true;
  }

 private:
  const int64_t bytes_max_;
  std::atomic<int64_t> reserved_bytes_ = 0;
};

}  // namespace procgen

#endif  // SERVER_POOL_QUOTA_BYTE_BUDGET_H_
