// A library that takes a while to load: meanwhile, its thread holds the loader's lock.

#include <unistd.h>

namespace {

__attribute__((constructor)) void Load() { usleep(500'000); }

}  // namespace
