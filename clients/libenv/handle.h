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

// What is behind a handle of the interface: environments, and the host's buffers for them.
// When the environments are lost (their server went, say), that is reported once, and from then on
// Observe writes rewards that are not numbers and leaves the rest as it is.
// Threads: compatible (one at a time).
struct LibenvHandle final {
 public:
  // Makes environments in this process, or on the server whose address the environment variable
  // PROCGEN_SERVER holds. Errors: INVALID_ARGUMENT, NOT_FOUND options; those of the server.
  static absl::StatusOr<std::unique_ptr<LibenvHandle>> Create(int env_count,
                                                              const LibenvOptions& options);

  std::vector<LibenvTensorType> TensorTypes(int space) const;
  // Errors: INVALID_ARGUMENT a buffer is null.
  absl::Status SetBuffers(const LibenvBuffers& buffers);
  // Errors: FAILED_PRECONDITION there are no buffers yet.
  absl::Status Observe();
  // An action that the engine does not know does nothing; the first is reported. Errors: as
  // Observe.
  absl::Status Act();
  // Writes a snapshot into `data` and returns how long it is. Errors: INVALID_ARGUMENT no such
  // environment, or no room; UNAVAILABLE the environments are lost.
  absl::StatusOr<int> SaveState(int environment, absl::Span<char> data);
  // Puts an environment into a saved state and refreshes its buffers. On error nothing has changed.
  // Errors: INVALID_ARGUMENT no such environment; UNAVAILABLE; those of Environments::RestoreState.
  absl::Status RestoreState(int environment, absl::string_view snapshot);

 private:
  LibenvHandle(const procgen::MakeOptions& options,
               std::unique_ptr<procgen::Environments> environments);

  absl::Status ObserveAll();
  void CheckActions();
  absl::Status CheckEnvironment(int environment) const;
  // Notes that the environments are lost, and says so once.
  void Lose(const absl::Status& status);

  const procgen::MakeOptions options_;
  const std::unique_ptr<procgen::Environments> environments_;
  std::optional<procgen::HostBuffers> buffers_;
  std::vector<int32_t> actions_;  // [N]
  bool is_lost_ = false;
  bool has_reported_action_ = false;
};

#endif  // CLIENTS_LIBENV_HANDLE_H_
