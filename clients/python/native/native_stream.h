#ifndef CLIENTS_PYTHON_NATIVE_NATIVE_STREAM_H_
#define CLIENTS_PYTHON_NATIVE_NATIVE_STREAM_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "clients/python/native/native_batch.h"
#include "clients/python/native/native_receiver.h"
#include "clients/python/native/process_owner.h"
#include "procgen/v1/step.pb.h"
#include "procgen_client/client.h"
#include "procgen_client/step_stream.h"
#include "pybind11/numpy.h"
#include "pybind11/pybind11.h"

namespace procgen_python {

// StepStream for Python. Waits for the server release the GIL.
// Threads: as StepStream.
class NativeStream {
 public:
  NativeStream(std::shared_ptr<procgen_client::Client> client,
               std::shared_ptr<procgen_client::StepStream> stream);
  // Ends the stream at once.
  ~NativeStream();  // NOLINT(bugprone-exception-escape)
  NativeStream(const NativeStream&) = delete;
  NativeStream& operator=(const NativeStream&) = delete;

  int32_t requests_in_flight_max() const { return requests_in_flight_max_; }
  int64_t in_flight() const { return in_flight_; }
  const std::shared_ptr<procgen_client::HeldBatches>& held_batches() const { return held_; }

  // Sends a serialised StepPoolRequest; returns its sequence number.
  int64_t Send(const pybind11::bytes& request);
  // Sends a step of the environments from `first_env` on. `actions`: [n], of any integer type.
  // `more`: empty, or a serialised Step with further fields.
  int64_t SendStep(const pybind11::array& actions, int32_t first_env, int32_t repeat_count,
                   bool observe, bool final_observations, int32_t chunk_count,
                   const pybind11::bytes& more);
  std::unique_ptr<NativeBatch> Receive();
  // Receive for an event loop: starts to wait, and returns an eventfd that becomes readable when
  // the answer has arrived. EndReceive returns the answer.
  int BeginReceive();
  std::unique_ptr<NativeBatch> EndReceive();
  // Ends the stream, and waits for the server to end it.
  void Close();
  // Ends the stream at once and releases the connection; from any thread.
  void Cancel();

 private:
  // Returns a reference that keeps the stream alive. Raises CancelledError: it was cancelled.
  std::shared_ptr<procgen_client::StepStream> stream() const;
  int64_t SendMessage(procgen::v1::StepPoolRequest request);
  std::unique_ptr<NativeBatch> Received(const absl::Status& status,
                                        std::unique_ptr<procgen_client::Batch> batch);

  const ProcessOwner owner_;
  const int32_t requests_in_flight_max_;
  const int32_t shared_batch_count_;
  const std::shared_ptr<procgen_client::HeldBatches> held_;
  std::shared_ptr<procgen_client::Client> client_;      // must outlive stream_
  std::shared_ptr<procgen_client::StepStream> stream_;  // null: cancelled
  const std::shared_ptr<BatchReserve> reserve_ = std::make_shared<BatchReserve>();
  const std::shared_ptr<const std::vector<pybind11::ssize_t>> shape_;
  // Null before the first BeginReceive. Outlives a cancelled stream: an event loop may wait for it.
  std::unique_ptr<NativeReceiver> receiver_;
  int64_t in_flight_ = 0;
};

}  // namespace procgen_python

#endif  // CLIENTS_PYTHON_NATIVE_NATIVE_STREAM_H_
