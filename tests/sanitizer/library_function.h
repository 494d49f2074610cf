#ifndef TESTS_SANITIZER_LIBRARY_FUNCTION_H_
#define TESTS_SANITIZER_LIBRARY_FUNCTION_H_

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>

namespace procgen {

// The definition in the loaded library `library` (its soname) of the function `mangled_name`, which
// the program defines, too. A program that does not get what its definition stands before cannot go
// on: it ends with a message.
template <typename Function>
Function* LibraryFunction(const char* library, const char* mangled_name) {
  void* found = dlsym(RTLD_NEXT, mangled_name);
  if (found == nullptr) {
    // RTLD_NEXT does not look into what came with a dlopen. The handle is kept, so the library
    // stays.
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
