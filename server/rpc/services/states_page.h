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

// One page of SaveStates: the environments left to save, and the size of the response so far. A
// page token contains the number of environments in earlier pages, the pool's change number and a
// hash of the request. The server keeps no state between pages.
// Threads: compatible.
class StatesPage {
 public:
  // Errors: INVALID_ARGUMENT an environment is out of range or listed twice, a size is out of
  // range, or the token is of another request; RESOURCE_EXHAUSTED a size exceeds the limit.
  static absl::StatusOr<std::unique_ptr<StatesPage>> Begin(const v1::SaveStatesRequest& request,
                                                           const PoolSession& pool,
                                                           const Limits& limits);

  // The environments left to save, in order.
  absl::Span<const int32_t> rest() const {
    return absl::MakeConstSpan(environments_).subspan(position_);
  }

  // Must be called before the first Add. Errors: ABORTED the pool's `change_number` differs from
  // that of the previous page.
  absl::Status Open(int64_t change_number);
  // Adds the snapshot of rest().front() to `response`. Returns false and adds nothing if it does
  // not fit.
  bool Add(int32_t environment, std::string snapshot, v1::SaveStatesResponse* response);
  // Completes the page: sets the token of the next one. Errors: RESOURCE_EXHAUSTED the first
  // snapshot did not fit.
  absl::Status Close(v1::SaveStatesResponse* response) const;

 private:
  StatesPage() = default;
  // Continues from the position of `token`.
  absl::Status Continue(const std::string& token);

  std::string pool_;
  uint64_t request_hash_ = 0;          // of the pool and the environments
  std::vector<int32_t> environments_;  // all of the request
  int64_t bytes_max_ = 0;
  int64_t bytes_ = 0;
  size_t position_ = 0;  // index of the next one in environments_
  bool is_first_ = true;
  int64_t change_number_ = 0;
};

}  // namespace procgen

#endif  // SERVER_RPC_SERVICES_STATES_PAGE_H_
