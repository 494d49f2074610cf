// Two threads call syscall for the first time at once. The first looks libc's function up, which
// takes as long as another thread loads a library. Argument: a library that loads slowly.

#include <dlfcn.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <thread>

int main(int argc, char** argv) {
  if (argc != 2) {
    return 2;
  }
  void* library = nullptr;
  std::thread loader([&] { library = dlopen(argv[1], RTLD_NOW); });
  usleep(100'000);  // the loader's lock is held
  const auto call = [] { syscall(SYS_gettid); };
  std::thread first(call);
  std::thread second(call);
  first.join();
  second.join();
  loader.join();
  return library == nullptr ? 1 : 0;
}
