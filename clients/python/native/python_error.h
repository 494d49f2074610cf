#ifndef CLIENTS_PYTHON_NATIVE_PYTHON_ERROR_H_
#define CLIENTS_PYTHON_NATIVE_PYTHON_ERROR_H_

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "pybind11/pybind11.h"

namespace procgen_python {

// Raises procgen_client.ProcgenError of the status's code, or the exception of a signal's handler.
// REQUIRES: the GIL is held.
[[noreturn]] void Raise(const absl::Status& status);

// Raises it unless the status is OK and no handler of a signal has raised anything.
void Check(const absl::Status& status);

// Returns what `wait` returns, which runs without the GIL.
template <typename Wait>
auto WithoutGil(const Wait& wait) {
  const pybind11::gil_scoped_release released;
  return wait();
}

// The value of a result; raises its error.
template <typename Value>
Value ValueOf(absl::StatusOr<Value> result) {
  Check(result.status());
  return *std::move(result);
}

// Runs the handlers of signals that have arrived, as the interpreter does between instructions:
// true if one has raised an exception, which is raised once the GIL is held again. Only the main
// thread runs handlers. REQUIRES: the GIL is not held.
bool SignalHandlerRaised();

}  // namespace procgen_python

#endif  // CLIENTS_PYTHON_NATIVE_PYTHON_ERROR_H_
