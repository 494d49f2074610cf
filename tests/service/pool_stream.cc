#include "tests/service/pool_stream.h"

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/io/zero_copy_stream_impl_lite.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"

namespace procgen {
namespace {

v1::Slice SliceOf(int32_t first, int32_t count) {
  v1::Slice slice;
  slice.set_first_env(first);
  slice.set_env_count(count);
  return slice;
}

// Equal messages have equal bytes only if the entries of maps are sorted.
std::string CanonicalBytes(const google::protobuf::MessageLite& message) {
  std::string bytes;
  google::protobuf::io::StringOutputStream file(&bytes);
  google::protobuf::io::CodedOutputStream coded(&file);
  coded.SetSerializationDeterministic(true);
  message.SerializeToCodedStream(&coded);
  return bytes;
}

}  // namespace

v1::RunPoolRequest StepRequest(const std::vector<int32_t>& actions, int32_t first) {
  v1::RunPoolRequest request;
  v1::Step* step = request.mutable_step();
  *step->mutable_slice() = SliceOf(first, static_cast<int32_t>(actions.size()));
  step->mutable_actions()->Add(actions.begin(), actions.end());
  return request;
}

v1::RunPoolRequest SliceStepRequest(int32_t first, int32_t count, int32_t action) {
  return StepRequest(std::vector<int32_t>(static_cast<size_t>(count), action), first);
}

v1::RunPoolRequest ObserveRequest(int32_t count, int32_t first) {
  v1::RunPoolRequest request;
  *request.mutable_observe()->mutable_slice() = SliceOf(first, count);
  return request;
}

v1::RunPoolRequest ResetRequest(int32_t count) {
  v1::RunPoolRequest request;
  *request.mutable_reset()->mutable_slice() = SliceOf(0, count);
  return request;
}

v1::RunPoolRequest StartRequest(const v1::PoolSpec& spec, const std::vector<v1::State>& states,
                                const std::string& pool_id) {
  v1::RunPoolRequest request;
  *request.mutable_start()->mutable_spec() = spec;
  request.mutable_start()->mutable_states()->Add(states.begin(), states.end());
  request.mutable_start()->set_pool_id(pool_id);
  return request;
}

v1::ClonePair Pair(int32_t source_environment, int32_t target_environment) {
  v1::ClonePair pair;
  pair.set_source_environment(source_environment);
  pair.set_target_environment(target_environment);
  return pair;
}

std::shared_ptr<grpc::Channel> ChannelTo(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  // A connection of its own.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

PoolStream::PoolStream(const std::shared_ptr<grpc::Channel>& channel, const std::string& token)
    : stub_(RunPoolService::NewStub(channel)), stream_([&] {
        if (!token.empty()) {
          context_.AddMetadata("authorization", absl::StrCat("Bearer ", token));
        }
        return stub_->RunPool(&context_);
      }()) {}

PoolStream::~PoolStream() {
  if (!status_.has_value()) {
    Cancel();
    Finish().IgnoreError();
  }
}

absl::StatusOr<v1::Started> PoolStream::Start(const v1::PoolSpec& spec,
                                              const std::vector<v1::State>& states,
                                              const std::string& pool_id) {
  absl::StatusOr<v1::RunPoolResponse> response = Call(StartRequest(spec, states, pool_id));
  if (!response.ok()) {
    return response.status();
  }
  started_ = response->started();
  return started_;
}

absl::StatusOr<v1::RunPoolResponse> PoolStream::Call(const v1::RunPoolRequest& request) {
  Write(request);
  return Read();
}

absl::Status PoolStream::Call(const v1::RunPoolRequest& request, v1::Batch* batch) {
  Write(request);
  return Read(batch);
}

absl::Status PoolStream::Step(const std::vector<int32_t>& actions, v1::Batch* batch) {
  return Call(StepRequest(actions), batch);
}

absl::Status PoolStream::Observe(v1::Batch* batch) {
  return Call(ObserveRequest(pool().spec().env_count()), batch);
}

absl::StatusOr<std::vector<v1::State>> PoolStream::Save(const std::vector<int32_t>& environments) {
  v1::RunPoolRequest request;
  request.mutable_save_states()->mutable_environments()->Add(environments.begin(),
                                                             environments.end());
  const absl::StatusOr<v1::RunPoolResponse> response = Call(request);
  if (!response.ok()) {
    return response.status();
  }
  return std::vector<v1::State>(response->states().states().begin(),
                                response->states().states().end());
}

absl::Status PoolStream::Restore(const std::vector<v1::State>& states) {
  v1::RunPoolRequest request;
  request.mutable_restore_states()->mutable_states()->Add(states.begin(), states.end());
  return Call(request).status();
}

absl::Status PoolStream::Clone(const std::vector<v1::ClonePair>& pairs) {
  v1::RunPoolRequest request;
  request.mutable_clone_states()->mutable_pairs()->Add(pairs.begin(), pairs.end());
  return Call(request).status();
}

absl::StatusOr<v1::Frames> PoolStream::Render(const std::vector<int32_t>& environments,
                                              int32_t size_px, v1::FrameFormat format,
                                              v1::FrameView view) {
  v1::RunPoolRequest request;
  v1::Render* render = request.mutable_render();
  render->mutable_environments()->Add(environments.begin(), environments.end());
  render->set_size_px(size_px);
  render->set_format(format);
  render->set_view(view);
  absl::StatusOr<v1::RunPoolResponse> response = Call(request);
  if (!response.ok()) {
    return response.status();
  }
  return std::move(*response->mutable_frames());
}

absl::StatusOr<v1::RunPoolResponse> PoolStream::Read() {
  v1::RunPoolResponse response;
  if (stream_->Read(&response)) {
    return response;
  }
  if (absl::Status status = Finish(); !status.ok()) {
    return status;
  }
  return absl::OutOfRangeError("the stream has ended");
}

absl::Status PoolStream::Read(v1::Batch* batch) {
  absl::StatusOr<v1::RunPoolResponse> response = Read();
  if (response.ok()) {
    *batch = std::move(*response->mutable_batch());
  }
  return response.status();
}

absl::Status PoolStream::Finish() {
  if (!status_.has_value()) {
    v1::RunPoolResponse unread;
    while (stream_->Read(&unread)) {
    }
    const grpc::Status status = stream_->Finish();
    status_ =
        absl::Status(static_cast<absl::StatusCode>(status.error_code()), status.error_message());
  }
  return *status_;
}

absl::Status PoolStream::Close() {
  HalfClose();
  return Finish();
}

bool PoolStream::drained() const {
  const auto& metadata = context_.GetServerTrailingMetadata();
  const auto drains = metadata.find("procgen-drains");
  return drains != metadata.end() && drains->second == "1";
}

bool EqualMessages(const google::protobuf::MessageLite& left,
                   const google::protobuf::MessageLite& right) {
  return CanonicalBytes(left) == CanonicalBytes(right);
}

}  // namespace procgen
