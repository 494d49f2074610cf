#include "clients/python/native/python_error.h"

#include <string>

namespace procgen_python {

namespace py = pybind11;

void Raise(const absl::Status& status) {
  if (PyErr_Occurred() == nullptr) {
    const py::object error = py::module_::import("procgen_client.errors")
                                 .attr("of_code")(static_cast<int>(status.code()),
                                                  py::str(std::string(status.message())));
    PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
  }
  throw py::error_already_set();
}

void Check(const absl::Status& status) {
  if (!status.ok() || PyErr_Occurred() != nullptr) {
    Raise(status);
  }
}

bool SignalHandlerRaised() {
  const PyGILState_STATE state = PyGILState_Ensure();
  const bool raised = PyErr_Occurred() != nullptr || PyErr_CheckSignals() != 0;
  PyGILState_Release(state);
  return raised;
}

}  // namespace procgen_python
