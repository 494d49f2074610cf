#ifndef SERVER_WIRE_CONVERT_SHARED_H_
#define SERVER_WIRE_CONVERT_SHARED_H_

#include <string>

#include "procgen/v1/step.pb.h"
#include "server/session/pool/pool_session.h"
#include "server/shared_memory/pipe_listener.h"
#include "server/shared_memory/shared_batch_slots.h"

namespace procgen {

// Fills in the description of a pool's shared memory. REQUIRES: it has a batch.
void FillSharedMemory(const PoolSession& pool, v1::SharedMemory* message);

// Offers the learner of a stream that was just attached the pipes that `key` opens.
void FillPipeTransport(const PipeListener& listener, const std::string& key,
                       v1::StepPoolResponse* response);

// Makes `response` the whole answer to `request`, and returns where its values are to be written:
// in the batch of shared memory that it was given.
Batch PrepareSharedResponse(const Request& request, const SharedBatchSlots& slots,
                            v1::StepPoolResponse* response);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_SHARED_H_
