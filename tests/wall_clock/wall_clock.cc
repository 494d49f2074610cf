// Interposes libc's wall clock with an offset, and waits that end at times of this clock. See
// README.md.

#include "tests/wall_clock/wall_clock.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <linux/futex.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <ctime>

namespace {

constexpr int64_t kSecond = 1'000'000'000;
// Interval at which a wait checks the clock.
constexpr int64_t kSlice = 10'000'000;
// Deadlines before this are times of the steady clock, which starts with the machine.
constexpr int64_t kSteadySecondsMax = 1'000'000'000;

using Offset = std::atomic<int64_t>;
static_assert(sizeof(Offset) == sizeof(int64_t));

Offset* MapOffset() {
  static Offset own{0};
  const char* const path = std::getenv("PROCGEN_WALL_CLOCK_FILE");
  const int file = path == nullptr ? -1 : open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    return &own;
  }
  void* const mapped = mmap(nullptr, sizeof(Offset), PROT_READ, MAP_SHARED, file, 0);
  close(file);
  return mapped == MAP_FAILED ? &own : static_cast<Offset*>(mapped);
}

Offset& CurrentOffset() {
  static Offset* const offset = MapOffset();
  return *offset;
}

// libc's own function, also if a sanitizer interposes it.
template <typename Function>
Function OfLibc(const char* name) {
  return reinterpret_cast<Function>(dlsym(dlopen("libc.so.6", RTLD_NOW | RTLD_NOLOAD), name));
}

template <typename Function>
Function Real(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

int64_t NanosecondsOf(const timespec& time) { return time.tv_sec * kSecond + time.tv_nsec; }
timespec TimespecOf(int64_t nanoseconds) {
  return {.tv_sec = nanoseconds / kSecond, .tv_nsec = nanoseconds % kSecond};
}

int64_t ReadClock(clockid_t clock) {
  timespec time = {};
  clock_gettime(clock, &time);
  return NanosecondsOf(time);
}

// Remaining time until `deadline`, at most the check interval; 0 if it has passed.
int64_t SliceUntil(int64_t deadline) {
  return std::clamp<int64_t>(deadline - ReadClock(CLOCK_REALTIME), 0, kSlice);
}

}  // namespace

namespace procgen {

void SetWallClockOffset(int64_t nanoseconds) { CurrentOffset() = nanoseconds; }

}  // namespace procgen

// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name): libc's names are reserved.
extern "C" {

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  static const auto real = Real<int (*)(clockid_t, timespec*)>("clock_gettime");
  const int result = real(clock, time);
  if (result == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE)) {
    *time = TimespecOf(NanosecondsOf(*time) + CurrentOffset());
  }
  return result;
}

int gettimeofday(timeval* time, void* /*zone*/) noexcept {
  const int64_t now = ReadClock(CLOCK_REALTIME);
  *time = {.tv_sec = now / kSecond, .tv_usec = now % kSecond / 1000};
  return 0;
}

time_t time(time_t* time) noexcept {
  const time_t now = ReadClock(CLOCK_REALTIME) / kSecond;
  if (time != nullptr) {
    *time = now;
  }
  return now;
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                           const timespec* deadline) {
  using Wait = int (*)(pthread_cond_t*, pthread_mutex_t*, const timespec*);
  static const auto real = Real<Wait>("pthread_cond_timedwait");
  if (deadline->tv_sec < kSteadySecondsMax) {
    return real(condition, mutex, deadline);
  }
  // Cyclone DDS waits like this. ThreadSanitizer ignores Cyclone's calls, so it has not seen the
  // lock of the mutex.
  using ClockWait = int (*)(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*);
  static const auto wait = OfLibc<ClockWait>("pthread_cond_clockwait");
  while (const int64_t slice = SliceUntil(NanosecondsOf(*deadline))) {
    const timespec until = TimespecOf(ReadClock(CLOCK_MONOTONIC) + slice);
    if (const int result = wait(condition, mutex, CLOCK_MONOTONIC, &until); result != ETIMEDOUT) {
      return result;
    }
  }
  return ETIMEDOUT;
}

long syscall(long number, ...) noexcept {  // NOLINT: libc's own signature
  va_list list;
  va_start(list, number);
  long arguments[6];                  // NOLINT
  for (long& argument : arguments) {  // NOLINT
    argument = va_arg(list, long);    // NOLINT
  }
  va_end(list);
  using Syscall = long (*)(long, ...);  // NOLINT: libc's own signature
  // Not a guarded static: threads that wait for its guard call syscall.
  static constinit std::atomic<Syscall> found = nullptr;
  if (found.load() == nullptr) {
    found = Real<Syscall>("syscall");
  }
  const Syscall real = found;
  const auto call = [&] {
    return real(number, arguments[0], arguments[1], arguments[2], arguments[3], arguments[4],
                arguments[5]);
  };
  // NOLINTNEXTLINE(performance-no-int-to-ptr): an argument of a system call
  const auto* const deadline = reinterpret_cast<const timespec*>(arguments[3]);
  const auto operation = static_cast<int>(arguments[1]);
  if (number != SYS_futex || (operation & FUTEX_CLOCK_REALTIME) == 0 ||
      (operation & FUTEX_CMD_MASK) != FUTEX_WAIT_BITSET || deadline == nullptr) {
    return call();
  }
  const int64_t end = NanosecondsOf(*deadline);
  arguments[1] = FUTEX_WAIT | (operation & FUTEX_PRIVATE_FLAG);
  while (const int64_t slice = SliceUntil(end)) {
    const timespec wait = TimespecOf(slice);
    arguments[3] = reinterpret_cast<long>(&wait);                         // NOLINT
    if (const long result = call(); result == 0 || errno != ETIMEDOUT) {  // NOLINT
      return result;
    }
  }
  errno = ETIMEDOUT;
  return -1;
}

}  // extern "C"
// NOLINTEND(readability-inconsistent-declaration-parameter-name)
