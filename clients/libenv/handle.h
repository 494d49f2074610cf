#ifndef CLIENTS_LIBENV_HANDLE_H_
#define CLIENTS_LIBENV_HANDLE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "clients/libenv/libenv.h"
#include "clients/libenv/make_options.h"
#include "envcore/pool/batch_numbers.h"
#include "procgen_client/local_pool.h"

namespace procgen {

// Writes one line to standard error in a single call. The interface has no other way to report
// errors.
void Report(absl::string_view message);

}  // namespace procgen

// Implementation of a handle: a pool of N environments, and the host's buffers for them.
// Threads: compatible (one at a time).
struct LibenvHandle final {
 public:
  // Errors: INVALID_ARGUMENT or NOT_FOUND for invalid options.
  static absl::StatusOr<std::unique_ptr<LibenvHandle>> Create(int env_count,
                                                              const LibenvOptions& options);

  std::vector<LibenvTensorType> TensorTypes(int space) const;
  // Copies the pointers, so the host may free their arrays. Errors: INVALID_ARGUMENT a buffer is
  // null.
  absl::Status SetBuffers(const LibenvBuffers& buffers);
  // Waits for the step and writes all buffers. Errors: FAILED_PRECONDITION no buffers are set.
  absl::Status Observe();
  // Starts a step with the actions in the buffers. Actions out of range do nothing; the first is
  // reported. Errors: as Observe.
  absl::Status Act();
  // Waits for the step, writes a snapshot to `data` and returns its size in bytes. Errors:
  // INVALID_ARGUMENT no such environment, or `data` is too small.
  absl::StatusOr<int> SaveState(int environment, absl::Span<char> data);
  // Waits for the step, restores a snapshot in an environment and refreshes its buffers. On error
  // nothing has changed. Errors: INVALID_ARGUMENT no such environment; those of RestoreStates.
  absl::Status RestoreState(int environment, absl::string_view snapshot);

 private:
  LibenvHandle(procgen::MakeOptions options, std::unique_ptr<procgen_client::Pool> pool);

  // Waits until no step runs; returns its status.
  absl::Status Wait();
  // Reads the current values of all environments.
  absl::Status Refresh();
  // Writes the values of an environment to its buffers.
  absl::Status Write(int32_t environment);
  absl::Status CheckBuffers() const;
  absl::Status CheckEnvironment(int environment) const;
  void* Info(size_t member, size_t environment) const {
    return infos_[member * actions_.size() + environment];
  }

  const procgen::MakeOptions options_;
  std::vector<uint8_t> observations_;  // [N, 64, 64, 3]
  procgen::BatchNumbers numbers_;      // [N]
  procgen::Batch batch_;               // of these
  std::vector<int32_t> actions_;       // [N]
  bool has_reported_action_ = false;
  // The host's buffers; null or empty: not set.
  LibenvBuffers buffers_ = {};
  std::vector<void*> observation_buffers_;  // [N] to uint8 [64, 64, 3]
  std::vector<void*> infos_;                // [members, N]
  std::vector<void*> action_buffers_;       // [N] to int32
  // Last: its threads write to the members above.
  const std::unique_ptr<procgen_client::Pool> pool_;
};

#endif  // CLIENTS_LIBENV_HANDLE_H_
