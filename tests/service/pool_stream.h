#ifndef TESTS_SERVICE_POOL_STREAM_H_
#define TESTS_SERVICE_POOL_STREAM_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "google/protobuf/message_lite.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "procgen/v1/pool_service.grpc.pb.h"

namespace procgen {

// The service of RunPool, and the method's path.
using RunPoolService = v1::PoolService;
inline constexpr char kRunPoolPath[] = "/procgen.v1.PoolService/RunPool";

// Requests for the environments from `first` on: one for each action, or `count`.
v1::RunPoolRequest StepRequest(const std::vector<int32_t>& actions, int32_t first = 0);
v1::RunPoolRequest SliceStepRequest(int32_t first, int32_t count, int32_t action);
v1::RunPoolRequest ObserveRequest(int32_t count, int32_t first = 0);
// Without resets, of the first `count` environments.
v1::RunPoolRequest ResetRequest(int32_t count);

v1::RunPoolRequest StartRequest(const v1::PoolSpec& spec, const std::vector<v1::State>& states = {},
                                const std::string& pool_id = "");

v1::ClonePair Pair(int32_t source_environment, int32_t target_environment);

// Opens a connection in plain text that accepts responses of any size.
std::shared_ptr<grpc::Channel> ChannelTo(const std::string& address);

// A stream of RunPool, through the generated stub. The destructor cancels it. Errors are those that
// end the stream; OUT_OF_RANGE: it has ended with OK.
// Threads: one at a time; Cancel from any thread.
class PoolStream {
 public:
  // Opens a stream. `token`: empty for none.
  explicit PoolStream(const std::shared_ptr<grpc::Channel>& channel, const std::string& token = "");
  ~PoolStream();
  PoolStream(const PoolStream&) = delete;
  PoolStream& operator=(const PoolStream&) = delete;

  // Creates the pool.
  absl::StatusOr<v1::Started> Start(const v1::PoolSpec& spec,
                                    const std::vector<v1::State>& states = {},
                                    const std::string& pool_id = "");
  // The pool as it was created.
  const v1::Pool& pool() const { return started_.pool(); }
  const std::string& name() const { return pool().name(); }

  // Sends one request and reads its response.
  absl::StatusOr<v1::RunPoolResponse> Call(const v1::RunPoolRequest& request);
  // The same for a request that is answered by a batch.
  absl::Status Call(const v1::RunPoolRequest& request, v1::Batch* batch);
  // Steps or observes all environments.
  absl::Status Step(const std::vector<int32_t>& actions, v1::Batch* batch);
  absl::Status Observe(v1::Batch* batch);
  absl::StatusOr<std::vector<v1::State>> Save(const std::vector<int32_t>& environments = {});
  absl::Status Restore(const std::vector<v1::State>& states);
  absl::Status Clone(const std::vector<v1::ClonePair>& pairs);
  absl::StatusOr<v1::Frames> Render(const std::vector<int32_t>& environments, int32_t size_px = 0,
                                    v1::FrameFormat format = v1::FRAME_FORMAT_RGB,
                                    v1::FrameView view = v1::FRAME_VIEW_HUMAN);

  // For requests in flight. False: the stream has ended.
  bool Write(const v1::RunPoolRequest& request) { return stream_->Write(request); }
  absl::StatusOr<v1::RunPoolResponse> Read();
  absl::Status Read(v1::Batch* batch);

  void HalfClose() { stream_->WritesDone(); }
  void Cancel() { context_.TryCancel(); }
  // Drops unread responses, and returns how the stream ended.
  absl::Status Finish();
  // Half-closes and finishes. The server has freed the pool.
  absl::Status Close();
  // Whether the stream ended because the server drains.
  bool drained() const;

 private:
  grpc::ClientContext context_;
  const std::unique_ptr<RunPoolService::Stub> stub_;
  const std::unique_ptr<grpc::ClientReaderWriter<v1::RunPoolRequest, v1::RunPoolResponse>> stream_;
  std::optional<absl::Status> status_;  // nothing: not finished
  v1::Started started_;
};

// Whether two messages are equal, bit for bit.
bool EqualMessages(const google::protobuf::MessageLite& left,
                   const google::protobuf::MessageLite& right);

}  // namespace procgen

#endif  // TESTS_SERVICE_POOL_STREAM_H_
