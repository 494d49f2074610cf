#ifndef CLIENTS_PYTHON_NATIVE_NATIVE_CLIENT_H_
#define CLIENTS_PYTHON_NATIVE_NATIVE_CLIENT_H_

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "clients/python/native/native_stream.h"
#include "clients/python/native/native_watch.h"
#include "clients/python/native/process_owner.h"
#include "procgen_client/client.h"
#include "pybind11/pybind11.h"

namespace procgen_python {

// Names and values of gRPC channel arguments.
using ChannelArguments = std::vector<std::pair<std::string, std::variant<int, std::string>>>;

// procgen_client::Client for Python, with serialised messages. Waits for the server release the GIL
// and run signal handlers.
// Threads: any method from any thread.
class NativeClient {
 public:
  // Connects. Times are in seconds; `timeout` as in ConnectOptions.
  static std::shared_ptr<NativeClient> Connect(const std::string& address,
                                               std::optional<double> timeout, double call_timeout,
                                               procgen_client::Credentials credentials,
                                               const ChannelArguments& channel_arguments);
  ~NativeClient();
  NativeClient(const NativeClient&) = delete;
  NativeClient& operator=(const NativeClient&) = delete;

  // Calls a unary method by its name, e.g. "CreatePool". Joins the pages of lists, and sends states
  // that do not fit one request in several.
  pybind11::bytes Call(const std::string& method, const pybind11::bytes& request);
  // Calls WatchNodes or WatchPool.
  std::unique_ptr<NativeWatch> Watch(const std::string& method, const pybind11::bytes& request);
  // Attaches with a serialised Attach. `reconnect_timeout`: in seconds. `held_batches`: those of
  // the learner's previous stream of the pool, or null.
  std::shared_ptr<NativeStream> Attach(const pybind11::bytes& attach, double reconnect_timeout,
                                       std::shared_ptr<procgen_client::HeldBatches> held_batches);
  // Ends all calls with CANCELLED, then closes the connection.
  void Close();

 private:
  NativeClient() = default;
  // Returns a reference that keeps the client alive. Raises CancelledError: it was closed.
  std::shared_ptr<procgen_client::Client> client() const;

  const ProcessOwner owner_{};
  // Shared with the cancellation checks of calls, which may outlive this object.
  const std::shared_ptr<std::atomic<bool>> is_closed_ = std::make_shared<std::atomic<bool>>(false);
  // Guarded by the GIL:
  std::shared_ptr<procgen_client::Client> client_;  // null: closed
  std::vector<std::weak_ptr<NativeStream>> streams_;
};

}  // namespace procgen_python

#endif  // CLIENTS_PYTHON_NATIVE_NATIVE_CLIENT_H_
