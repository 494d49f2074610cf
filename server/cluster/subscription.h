#ifndef SERVER_CLUSTER_SUBSCRIPTION_H_
#define SERVER_CLUSTER_SUBSCRIPTION_H_

#include <utility>

#include "absl/functional/any_invocable.h"

namespace procgen {

// A subscription, which ends on destruction; no callback runs after that. Destroy it before the
// object subscribed to, and not inside the callback.
class Subscription {
 public:
  Subscription() = default;
  // `end`: called once, on destruction.
  explicit Subscription(absl::AnyInvocable<void()> end) : end_(std::move(end)) {}
  ~Subscription() { End(); }
  Subscription(Subscription&& other) noexcept : end_(std::exchange(other.end_, nullptr)) {}
  Subscription& operator=(Subscription&& other) noexcept {
    if (this != &other) {
      End();
      end_ = std::exchange(other.end_, nullptr);
    }
    return *this;
  }

 private:
  void End() {
    if (end_ != nullptr) {
      std::exchange(end_, nullptr)();
    }
  }

  absl::AnyInvocable<void()> end_;
};

}  // namespace procgen

#endif  // SERVER_CLUSTER_SUBSCRIPTION_H_
