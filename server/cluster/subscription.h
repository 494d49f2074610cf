#ifndef SERVER_CLUSTER_SUBSCRIPTION_H_
#define SERVER_CLUSTER_SUBSCRIPTION_H_

#include <utility>

#include "absl/functional/any_invocable.h"

namespace procgen {

// That somebody is told of something, until this goes; once it has gone nobody is being told any
// more. It must go before what it was subscribed to, and not in the call that tells.
class Subscription {
 public:
  Subscription() = default;
  // `end` is called once, when this goes.
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
