// Annotates absl::Mutex, absl::CondVar, absl::Notification and absl::call_once for ThreadSanitizer.
// Debian's Abseil is built without the sanitizer, which would see no lock and report races on all
// guarded data, in our code and in gRPC, which uses the same locks.
// Linked into every program of the tsan preset, these definitions come before the library's and
// call them. Functions named ...WithTimeout are missing because they call ...WithDeadline.
//
// While a lock is acquired or released the sanitizer ignores the thread, so conditions that Abseil
// evaluates for another thread, with the lock held, are not reported as races.

#include <sanitizer/tsan_interface.h>

#include <atomic>
#include <cstdint>

#include "absl/base/internal/spinlock_wait.h"
#include "absl/synchronization/mutex.h"
#include "absl/synchronization/notification.h"
#include "tests/sanitizer/library_function.h"

namespace {

constexpr char kLibrary[] = "libabsl_synchronization.so.20220623";

void BeforeWait(absl::Mutex* mutex) { __tsan_mutex_pre_unlock(mutex, 0); }

void AfterWait(absl::Mutex* mutex) {
  __tsan_mutex_post_unlock(mutex, 0);
  __tsan_mutex_pre_lock(mutex, 0);
  __tsan_mutex_post_lock(mutex, 0, 0);
}

}  // namespace

namespace absl {
ABSL_NAMESPACE_BEGIN

Mutex::~Mutex() {
  static auto* const next =
      procgen::LibraryFunction<void(Mutex*)>(kLibrary, "_ZN4absl7debian35MutexD1Ev");
  __tsan_mutex_destroy(this, __tsan_mutex_not_static);
  next(this);
}

void Mutex::Lock() {
  static auto* const next =
      procgen::LibraryFunction<void(Mutex*)>(kLibrary, "_ZN4absl7debian35Mutex4LockEv");
  __tsan_mutex_pre_lock(this, 0);
  next(this);
  __tsan_mutex_post_lock(this, 0, 0);
}

void Mutex::Unlock() {
  static auto* const next =
      procgen::LibraryFunction<void(Mutex*)>(kLibrary, "_ZN4absl7debian35Mutex6UnlockEv");
  __tsan_mutex_pre_unlock(this, 0);
  next(this);
  __tsan_mutex_post_unlock(this, 0);
}

bool Mutex::TryLock() {
  static auto* const next =
      procgen::LibraryFunction<bool(Mutex*)>(kLibrary, "_ZN4absl7debian35Mutex7TryLockEv");
  __tsan_mutex_pre_lock(this, __tsan_mutex_try_lock);
  const bool locked = next(this);
  __tsan_mutex_post_lock(
      this, locked ? __tsan_mutex_try_lock : __tsan_mutex_try_lock | __tsan_mutex_try_lock_failed,
      0);
  return locked;
}

void Mutex::LockWhen(const Condition& condition) {
  static auto* const next = procgen::LibraryFunction<void(Mutex*, const Condition&)>(
      kLibrary, "_ZN4absl7debian35Mutex8LockWhenERKNS0_9ConditionE");
  __tsan_mutex_pre_lock(this, 0);
  next(this, condition);
  __tsan_mutex_post_lock(this, 0, 0);
}

void Mutex::Await(const Condition& condition) {
  static auto* const next = procgen::LibraryFunction<void(Mutex*, const Condition&)>(
      kLibrary, "_ZN4absl7debian35Mutex5AwaitERKNS0_9ConditionE");
  BeforeWait(this);
  next(this, condition);
  AfterWait(this);
}

bool Mutex::AwaitWithDeadline(const Condition& condition, Time deadline) {
  static auto* const next = procgen::LibraryFunction<bool(Mutex*, const Condition&, Time)>(
      kLibrary, "_ZN4absl7debian35Mutex17AwaitWithDeadlineERKNS0_9ConditionENS0_4TimeE");
  BeforeWait(this);
  const bool result = next(this, condition, deadline);
  AfterWait(this);
  return result;
}

bool Mutex::LockWhenWithDeadline(const Condition& condition, Time deadline) {
  static auto* const next = procgen::LibraryFunction<bool(Mutex*, const Condition&, Time)>(
      kLibrary, "_ZN4absl7debian35Mutex20LockWhenWithDeadlineERKNS0_9ConditionENS0_4TimeE");
  __tsan_mutex_pre_lock(this, 0);
  const bool result = next(this, condition, deadline);
  __tsan_mutex_post_lock(this, 0, 0);
  return result;
}

void CondVar::Wait(Mutex* mutex) {
  static auto* const next = procgen::LibraryFunction<void(CondVar*, Mutex*)>(
      kLibrary, "_ZN4absl7debian37CondVar4WaitEPNS0_5MutexE");
  BeforeWait(mutex);
  next(this, mutex);
  AfterWait(mutex);
}

bool CondVar::WaitWithDeadline(Mutex* mutex, Time deadline) {
  static auto* const next = procgen::LibraryFunction<bool(CondVar*, Mutex*, Time)>(
      kLibrary, "_ZN4absl7debian37CondVar16WaitWithDeadlineEPNS0_5MutexENS0_4TimeE");
  BeforeWait(mutex);
  const bool result = next(this, mutex, deadline);
  AfterWait(mutex);
  return result;
}

void Notification::Notify() {
  static auto* const next = procgen::LibraryFunction<void(Notification*)>(
      kLibrary, "_ZN4absl7debian312Notification6NotifyEv");
  __tsan_release(this);
  next(this);
}

void Notification::WaitForNotification() const {
  static auto* const next = procgen::LibraryFunction<void(const Notification*)>(
      kLibrary, "_ZNK4absl7debian312Notification19WaitForNotificationEv");
  next(this);
  __tsan_acquire(const_cast<Notification*>(this));
}

namespace base_internal {

// How absl::call_once waits for another thread's call. The sanitizer sees that thread's last write
// of the word; the load shows it that this thread has read it.
uint32_t SpinLockWait(std::atomic<uint32_t>* word, int transition_count,
                      const SpinLockWaitTransition* transitions, SchedulingMode mode) {
  static auto* const next = procgen::LibraryFunction<uint32_t(
      std::atomic<uint32_t>*, int, const SpinLockWaitTransition*, SchedulingMode)>(
      "libabsl_spinlock_wait.so.20220623",
      "_ZN4absl7debian313base_internal12SpinLockWaitEPSt6atomicIjEiPKNS1_"
      "22SpinLockWaitTransitionENS1_14SchedulingModeE");
  const uint32_t before = next(word, transition_count, transitions, mode);
  word->load(std::memory_order_acquire);
  return before;
}

}  // namespace base_internal

ABSL_NAMESPACE_END
}  // namespace absl
