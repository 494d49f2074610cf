#ifndef SERVER_RPC_RUN_POOL_RUN_H_
#define SERVER_RPC_RUN_POOL_RUN_H_

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "grpcpp/support/byte_buffer.h"
#include "procgen/v1/run.pb.h"
#include "server/pool/pool_session.h"
#include "server/pool/pool_supervisor.h"
#include "server/rpc/run/batch_builder.h"
#include "server/wire/convert_frames.h"
#include "server/wire/convert_step.h"

namespace procgen {

// The pool of one RunPool stream: created by its first request, freed by Close. Independent of the
// connection.
// Threads: one request at a time; OnLearnerGone from any thread at any time.
class PoolRun final : public ResponseSink, public std::enable_shared_from_this<PoolRun> {
 public:
  // Receives the serialised response, or the error that ends the stream. Called once, on any
  // thread, also on the calling one.
  using Respond = absl::AnyInvocable<void(absl::StatusOr<grpc::ByteBuffer>)>;
  // Called at most once, from any thread: the stream must end with this error.
  using OnEnd = std::function<void(const absl::Status& reason)>;

  // `supervisor` must outlive this. `on_end` is not called after Close.
  PoolRun(PoolSupervisor* supervisor, std::string owner, OnEnd on_end);

  // Executes a request, which must stay valid until `respond`. `arrival_time`: on the steady clock.
  void Execute(const v1::RunPoolRequest& message, absl::Time arrival_time, Respond respond);
  // The learner left: a request does not wait for the end of a pause.
  void OnLearnerGone();
  // Frees the pool. REQUIRES: no request is being executed.
  void Close();

  // ResponseSink, of a step, reset, observe or level sampler.
  Batch Prepare() override;
  void Done(const absl::Status& status) override;

 private:
  void Start(const v1::StartPool& start);
  void OnCreated(const v1::StartPool& start);
  void RespondStarted();
  // Charges a level sampler to the owner for as long as it exists.
  absl::Status Hold(std::shared_ptr<const LevelSampler>* sampler) const;
  void ExecuteBatch(const v1::RunPoolRequest& message, absl::Time arrival_time);
  // Whether the request being executed returns a batch.
  bool HasValues() const {
    return memory_.request.kind != Request::Kind::kSample && !memory_.request.acknowledge_only;
  }
  void Save(const v1::SaveEnvironments& message);
  void RespondStates(absl::StatusOr<std::vector<std::string>> snapshots);
  void Restore(const google::protobuf::RepeatedPtrField<v1::State>& states, PoolSession::Done done);
  void Clone(const v1::CloneEnvironments& message);
  void Render(const v1::Render& message);
  // Adds frames without images to the response. In a turn.
  void FillFrames(absl::Span<const int32_t> environments, const RenderSpec& spec);
  void RespondFrames(v1::FrameFormat format, Draw draw);

  // Takes a turn of the pool and calls `begin` in it, or ends the request with an error.
  void InTurn(absl::AnyInvocable<void()> begin);
  void RespondAck(const absl::Status& status);
  void RespondWith(absl::StatusOr<grpc::ByteBuffer> response);

  PoolSupervisor* const supervisor_;
  const std::string owner_;
  const OnEnd on_end_;
  std::shared_ptr<PoolSession> pool_;  // null until it is created
  std::optional<BatchBuilder> builder_;
  RequestMemory memory_;          // of the request being executed
  std::vector<int32_t> saved_;    // environments of the request being executed
  v1::RunPoolResponse response_;  // to the request being executed, other than a batch
  Respond respond_;               // null: no request is being executed
};

}  // namespace procgen

#endif  // SERVER_RPC_RUN_POOL_RUN_H_
