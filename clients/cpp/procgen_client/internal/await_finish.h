#ifndef PROCGEN_CLIENT_INTERNAL_AWAIT_FINISH_H_
#define PROCGEN_CLIENT_INTERNAL_AWAIT_FINISH_H_

#include "grpcpp/client_context.h"
#include "grpcpp/completion_queue.h"
#include "procgen_client/cancellation.h"

namespace procgen_client {

// Waits for the Finish of a call, the only operation on `queue`, which it shuts down. Cancels the
// call once `cancellation` is. gRPC's synchronous API cannot be interrupted.
void AwaitFinish(grpc::ClientContext* context, grpc::CompletionQueue* queue,
                 Cancellation* cancellation);

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_INTERNAL_AWAIT_FINISH_H_
