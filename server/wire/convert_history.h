#ifndef SERVER_WIRE_CONVERT_HISTORY_H_
#define SERVER_WIRE_CONVERT_HISTORY_H_

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "procgen/v1/pool_service.pb.h"
#include "server/pool/history/pool_history.h"

namespace procgen {

// The span of a request. Errors: INVALID_ARGUMENT it is out of range.
absl::StatusOr<absl::Duration> HistorySpanOf(const v1::GetPoolHistoryRequest& request);

// Converts rows to a message.
void FillHistory(const PoolHistory::Series& series, v1::PoolHistory* message);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_HISTORY_H_
