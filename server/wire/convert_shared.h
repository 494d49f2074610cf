#ifndef SERVER_WIRE_CONVERT_SHARED_H_
#define SERVER_WIRE_CONVERT_SHARED_H_

#include <string>

#include "procgen/v1/step.pb.h"
#include "server/session/pool/pool_session.h"
#include "server/shared_memory/pipe_listener.h"
#include "server/shared_memory/shared_batch_slots.h"

namespace procgen {

// Sets `message` to the description of a pool's shared memory. REQUIRES: the pool has a batch.
void FillSharedMemory(const PoolSession& pool, v1::SharedMemory* message);

// Adds to the response to attach how the learner opens its pipes; `key` authenticates it.
void FillPipeTransport(const PipeListener& listener, const std::string& key,
                       v1::StepPoolResponse* response);

// Makes `response` the only response to `request`. Returns the arrays of its batch in shared
// memory.
Batch PrepareSharedResponse(const Request& request, const SharedBatchSlots& slots,
                            v1::StepPoolResponse* response);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_SHARED_H_
