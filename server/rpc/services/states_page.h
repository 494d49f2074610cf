#ifndef SERVER_RPC_SERVICES_STATES_PAGE_H_
#define SERVER_RPC_SERVICES_STATES_PAGE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "procgen/v1/states.pb.h"
#include "server/session/pool/pool_session.h"
#include "server/session/quota/limits.h"

namespace procgen {

// One page of SaveStates: which environments a request still asks for, and its answer while it is
// filled. A page token tells how many were answered, the pool's change number then, and a hash of
// what was asked for; nothing is kept on the server between two pages.
// Threads: compatible (one at a time).
class StatesPage {
 public:
  // Errors: INVALID_ARGUMENT an environment out of range or named twice, a size out of range, a
  // token that is none of this request; RESOURCE_EXHAUSTED a size beyond the limit.
  static absl::StatusOr<std::unique_ptr<StatesPage>> Begin(const v1::SaveStatesRequest& request,
                                                           const PoolSession& pool,
                                                           const Limits& limits);

  // Those that are still to be answered, in order.
  absl::Span<const int32_t> rest() const {
    return absl::MakeConstSpan(environments_).subspan(position_);
  }

  // Before the first is added. Errors: ABORTED the pool's `change_number` is another than at the
  // page before.
  absl::Status Open(int64_t change_number);
  // Adds the first of rest() to `response`; false, and nothing is added: it has no room there.
  bool Add(int32_t environment, std::string snapshot, v1::SaveStatesResponse* response);
  // Once all that fits is added: sets the token. Errors: RESOURCE_EXHAUSTED nothing fitted.
  absl::Status Close(v1::SaveStatesResponse* response) const;

 private:
  StatesPage() = default;
  // Goes on where `token` says.
  absl::Status Continue(const std::string& token);

  std::string pool_;
  uint64_t request_hash_ = 0;          // of the pool and the environments
  std::vector<int32_t> environments_;  // all that were asked for
  int64_t bytes_max_ = 0;
  int64_t bytes_ = 0;
  size_t position_ = 0;  // of the next in environments_
  bool is_first_ = true;
  int64_t change_number_ = 0;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_STATES_PAGE_H_
