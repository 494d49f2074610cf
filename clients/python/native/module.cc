// procgen_client._native: the C++ client as a Python module, private to the package. Its types are
// in ../procgen_client/_native.pyi.
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "clients/python/native/native_batch.h"
#include "clients/python/native/native_client.h"
#include "clients/python/native/native_stream.h"
#include "clients/python/native/native_watch.h"
#include "pybind11/pybind11.h"
#include "pybind11/stl.h"

namespace py = pybind11;

// Types are module-local, because a forked child loads the module again.
PYBIND11_MODULE(_native, module) {
  using procgen_client::HeldBatches;
  using procgen_python::NativeBatch;
  using procgen_python::NativeClient;
  using procgen_python::NativeStream;
  using procgen_python::NativeWatch;
  using procgen_python::ObservationMemory;

  module.doc() = "The C++ client of Procgen Server; private to procgen_client.";

  // NOLINTBEGIN(bugprone-unused-raii): they register types.
  py::class_<ObservationMemory, std::shared_ptr<ObservationMemory>>(
      module, "ObservationMemory", py::module_local(), "Memory of observation arrays.");

  py::class_<NativeBatch>(module, "Batch", py::module_local(), "An answer of a stream.")
      .def_property_readonly("sequence_number", &NativeBatch::sequence_number)
      .def_property_readonly("first_env", &NativeBatch::first_env)
      .def("array", &NativeBatch::Array, py::arg("name"));

  py::class_<HeldBatches, std::shared_ptr<HeldBatches>>(
      module, "HeldBatches", py::module_local(),
      "The batches of shared memory that arrays refer to.");
  // NOLINTEND(bugprone-unused-raii)

  py::class_<NativeStream, std::shared_ptr<NativeStream>>(module, "Stream", py::module_local(),
                                                          "The stream of an attached learner.")
      .def_property_readonly("requests_in_flight_max", &NativeStream::requests_in_flight_max)
      .def_property_readonly("in_flight", &NativeStream::in_flight)
      .def_property_readonly("held_batches", &NativeStream::held_batches)
      .def("send", &NativeStream::Send, py::arg("request"))
      .def("send_step", &NativeStream::SendStep, py::arg("actions"), py::arg("first_env"),
           py::arg("repeat_count"), py::arg("observe"), py::arg("final_observations"),
           py::arg("chunk_count"), py::arg("more"))
      .def("receive", &NativeStream::Receive)
      .def("begin_receive", &NativeStream::BeginReceive)
      .def("end_receive", &NativeStream::EndReceive)
      .def("close", &NativeStream::Close)
      .def("cancel", &NativeStream::Cancel);

  py::class_<NativeWatch>(module, "Watch", py::module_local(),
                          "A server stream conflated to the latest message.")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &NativeWatch::Next)
      .def("close", &NativeWatch::Close);

  py::class_<NativeClient, std::shared_ptr<NativeClient>>(module, "Connection", py::module_local(),
                                                          "A connection to a server.")
      .def(py::init([](const std::string& address, std::optional<double> timeout,
                       double call_timeout, const py::bytes& ca, const py::bytes& certificate,
                       const py::bytes& key, std::string token, bool token_in_plain_text,
                       const procgen_python::ChannelArguments& channel_options) {
             return NativeClient::Connect(
                 address, timeout, call_timeout,
                 {ca, certificate, key, std::move(token), token_in_plain_text}, channel_options);
           }),
           py::arg("address"), py::kw_only(), py::arg("timeout"), py::arg("call_timeout"),
           py::arg("ca"), py::arg("certificate"), py::arg("key"), py::arg("token"),
           py::arg("token_in_plain_text"), py::arg("channel_options"))
      .def("call", &NativeClient::Call, py::arg("method"), py::arg("request"))
      .def("watch", &NativeClient::Watch, py::arg("method"), py::arg("request"))
      .def("attach", &NativeClient::Attach, py::arg("attach"), py::arg("reconnect_timeout"),
           py::arg("held_batches"))
      .def("close", &NativeClient::Close);
}
