#ifndef CLIENTS_LIBENV_HOST_BUFFERS_H_
#define CLIENTS_LIBENV_HOST_BUFFERS_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "clients/libenv/environments.h"
#include "clients/libenv/libenv.h"
#include "clients/libenv/tensor_types.h"

namespace procgen {

// The host's memory for the values of N environments: pointers to each environment's value of each
// member. The pointer arrays are copied, so the host may free them.
// Threads: compatible (one at a time).
class HostBuffers {
 public:
  // Errors: INVALID_ARGUMENT a pointer is null (the message names the array).
  static absl::StatusOr<HostBuffers> Create(const LibenvBuffers& buffers, int32_t env_count,
                                            bool render_human);

  // Reads the actions. `actions`: [N].
  void ReadActions(absl::Span<int32_t> actions) const;
  // Writes all values except the human views.
  void Write(const EnvironmentValues& observed) const;
  // As Write, for environment `i` only.
  void WriteOne(size_t i, const EnvironmentValues& observed) const;
  // Buffer of the human view of an environment. REQUIRES: render_human.
  absl::Span<uint8_t> HumanView(int32_t environment) const;

 private:
  HostBuffers() = default;
  void* Info(InfoMember member, size_t environment) const {
    return infos_[static_cast<size_t>(member) * env_count_ + environment];
  }

  size_t env_count_ = 0;
  float* rewards_ = nullptr;         // [N]
  uint8_t* firsts_ = nullptr;        // [N]
  std::vector<void*> observations_;  // [N] to uint8 [64, 64, 3]
  std::vector<void*> infos_;         // [members, N]
  std::vector<void*> actions_;       // [N] to int32
};

}  // namespace procgen

#endif  // CLIENTS_LIBENV_HOST_BUFFERS_H_
