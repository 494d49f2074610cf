#include "server/rpc/step/step_pool_reactor.h"

#include <cstdint>
#include <string>
#include <utility>

#include "grpcpp/server_context.h"
#include "server/rpc/call/drain_trailer.h"
#include "server/rpc/grpc/method_name.h"
#include "server/rpc/grpc/parse_message.h"
#include "server/rpc/step/response.h"

namespace procgen {

StepPoolReactor* StepPoolReactor::Start(PoolSupervisor* supervisor,
                                        const CallAccounting* accounting,
                                        PipeListener* pipe_listener,
                                        grpc::CallbackServerContext* context, Caller caller) {
  auto* const reactor = new StepPoolReactor(supervisor, accounting, context);
  reactor->stream_ = std::make_shared<StepStream>(
      StepStream::Context{.supervisor = supervisor,
                          .accounting = accounting,
                          .pipe_listener = pipe_listener,
                          .peer = context->peer(),
                          .transport = reactor,
                          .end = [reactor](const absl::Status& status) { reactor->End(status); }},
      std::move(caller));
  reactor->stream_->Start();
  return reactor;
}

StepPoolReactor::StepPoolReactor(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                 grpc::CallbackServerContext* context)
    : supervisor_(supervisor), accounting_(accounting), context_(context) {}

bool StepPoolReactor::Read() {
  StartRead(&read_bytes_);
  return true;
}

void StepPoolReactor::OnReadDone(bool ok) {
  stream_->OnRead(this, ok ? absl::OkStatus() : absl::CancelledError());
}

absl::Status StepPoolReactor::Parse(StreamRequest* request) {
  grpc::ByteBuffer bytes;
  bytes.Swap(&read_bytes_);
  request->message_bytes = bytes.Length();
  supervisor_->metrics().AddReceivedBytes(static_cast<int64_t>(bytes.Length()));
  return ParseMessage(bytes, &request->message);
}

void StepPoolReactor::Write(Outgoing* outgoing) {
  if (!outgoing->bytes.Valid()) {
    outgoing->bytes = Serialized(*outgoing->response);
  }
  supervisor_->metrics().AddSentBytes(static_cast<int64_t>(outgoing->bytes.Length()));
  StartWrite(&outgoing->bytes);
}

void StepPoolReactor::OnWriteDone(bool ok) { stream_->OnWritten(ok); }

void StepPoolReactor::OnCancel() { stream_->OnCancel(); }

void StepPoolReactor::End(const absl::Status& status) {
  AddDrainTrailer(status, *supervisor_, context_);
  Finish(accounting_->EndCall(MethodNameOf<v1::StepPoolRequest>(), status));
}

void StepPoolReactor::OnDone() { delete this; }

}  // namespace procgen
