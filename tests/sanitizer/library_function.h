#ifndef TESTS_SANITIZER_LIBRARY_FUNCTION_H_
#define TESTS_SANITIZER_LIBRARY_FUNCTION_H_

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>

namespace procgen {

// The definition of `mangled_name` in the loaded library `library` (its soname), which this program
// interposes. Ends the program with a message if it is missing.
template <typename Function>
Function* LibraryFunction(const char* library, const char* mangled_name) {
  void* found = dlsym(RTLD_NEXT, mangled_name);
  if (found == nullptr) {
    // RTLD_NEXT does not search libraries that were loaded with dlopen. The handle is kept, so the
    // library stays loaded.
    void* handle = dlopen(library, RTLD_LAZY | RTLD_NOLOAD);
    found = handle == nullptr ? nullptr : dlsym(handle, mangled_name);
  }
  if (found == nullptr) {
    std::fprintf(stderr, "thread sanitizer: %s, which was called, is not in %s\n", mangled_name,
                 library);
    std::abort();
  }
  return reinterpret_cast<Function*>(found);
}

}  // namespace procgen

#endif  // TESTS_SANITIZER_LIBRARY_FUNCTION_H_
