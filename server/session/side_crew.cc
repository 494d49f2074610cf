#include "server/session/side_crew.h"

#include <utility>

namespace procgen {

SideCrew::SideCrew(int32_t thread_count) {
  threads_.reserve(static_cast<size_t>(thread_count));
  for (int32_t i = 0; i < thread_count; ++i) {
    threads_.emplace_back([this] { WorkUntilStopped(); });
  }
}

SideCrew::~SideCrew() {
  {
    absl::MutexLock lock(&mutex_);
    stops_ = true;
  }
  for (std::thread& thread : threads_) {
    thread.join();
  }
}

void SideCrew::Run(absl::AnyInvocable<void()> work) {
  absl::MutexLock lock(&mutex_);
  work_.push_back(std::move(work));
}

void SideCrew::WorkUntilStopped() {
  while (true) {
    absl::AnyInvocable<void()> work;
    {
      absl::MutexLock lock(&mutex_);
      mutex_.Await(absl::Condition(this, &SideCrew::HasWorkOrStops));
      if (work_.empty()) {
        return;
      }
      work = std::move(work_.front());
      work_.pop_front();
    }
    work();
  }
}

}  // namespace procgen
