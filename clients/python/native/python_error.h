#ifndef CLIENTS_PYTHON_NATIVE_PYTHON_ERROR_H_
#define CLIENTS_PYTHON_NATIVE_PYTHON_ERROR_H_

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "pybind11/pybind11.h"

namespace procgen_python {

// Raises the pending exception of a signal handler, else the ProcgenError of the status's code.
// REQUIRES: the GIL is held.
[[noreturn]] void Raise(const absl::Status& status);

// Calls Raise unless the status is OK and no signal handler has raised an exception.
void Check(const absl::Status& status);

// Calls `wait` without the GIL, and returns its result.
template <typename Wait>
auto WithoutGil(const Wait& wait) {
  const pybind11::gil_scoped_release released;
  return wait();
}

// Returns the value of a result, or raises its error.
template <typename Value>
Value ValueOf(absl::StatusOr<Value> result) {
  Check(result.status());
  return *std::move(result);
}

// Runs pending signal handlers, as the interpreter does between instructions. Returns true if one
// raised an exception, which Check raises later. Only the main thread runs handlers. REQUIRES: the
// GIL is not held.
bool SignalHandlerRaised();

}  // namespace procgen_python

#endif  // CLIENTS_PYTHON_NATIVE_PYTHON_ERROR_H_
