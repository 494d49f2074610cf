#ifndef CLIENTS_LIBENV_HANDLE_H_
#define CLIENTS_LIBENV_HANDLE_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "clients/libenv/environments.h"
#include "clients/libenv/host_buffers.h"
#include "clients/libenv/libenv.h"
#include "clients/libenv/make_options.h"

// Implementation of a handle: environments, and the host's buffers for them.
// Threads: compatible (one at a time).
struct LibenvHandle final {
 public:
  // Errors: INVALID_ARGUMENT or NOT_FOUND for invalid options.
  static absl::StatusOr<std::unique_ptr<LibenvHandle>> Create(int env_count,
                                                              const LibenvOptions& options);

  std::vector<LibenvTensorType> TensorTypes(int space) const;
  // Errors: INVALID_ARGUMENT a buffer is null.
  absl::Status SetBuffers(const LibenvBuffers& buffers);
  // Waits for the step and writes all buffers. Errors: FAILED_PRECONDITION no buffers are set.
  absl::Status Observe();
  // Starts a step with the actions in the buffers. Actions out of range do nothing; the first is
  // reported. Errors: as Observe.
  absl::Status Act();
  // Writes a snapshot to `data` and returns its size in bytes. Errors: INVALID_ARGUMENT no such
  // environment, or `data` is too small.
  absl::StatusOr<int> SaveState(int environment, absl::Span<char> data);
  // Restores a snapshot in an environment and refreshes its buffers. On error nothing has changed.
  // Errors: INVALID_ARGUMENT no such environment; those of Environments::RestoreState.
  absl::Status RestoreState(int environment, absl::string_view snapshot);

 private:
  LibenvHandle(const procgen::MakeOptions& options,
               std::unique_ptr<procgen::Environments> environments);

  void CheckActions();
  absl::Status CheckEnvironment(int environment) const;

  const procgen::MakeOptions options_;
  const std::unique_ptr<procgen::Environments> environments_;
  std::optional<procgen::HostBuffers> buffers_;
  std::vector<int32_t> actions_;  // [N]
  bool has_reported_action_ = false;
};

#endif  // CLIENTS_LIBENV_HANDLE_H_
