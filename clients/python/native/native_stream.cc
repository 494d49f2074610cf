#include "clients/python/native/native_stream.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/python/native/python_error.h"

namespace procgen_python {
namespace {

namespace py = pybind11;
namespace v1 = procgen::v1;

constexpr int64_t kActionMin = -1;
constexpr int64_t kActionCount = 15;

std::shared_ptr<const std::vector<py::ssize_t>> ShapeOf(const v1::Pool& pool) {
  return std::make_shared<const std::vector<py::ssize_t>>(pool.observation_shape().begin(),
                                                          pool.observation_shape().end());
}

// Appends `actions` to the message. Raises InvalidArgumentError: not a vector of integers, or a
// value out of range.
void SetActions(const py::array& actions, v1::Step* step) {
  const char kind = actions.dtype().kind();
  if (actions.ndim() != 1 || (kind != 'i' && kind != 'u')) {
    const absl::Span<const py::ssize_t> shape(actions.shape(), static_cast<size_t>(actions.ndim()));
    Raise(absl::InvalidArgumentError(absl::StrCat(
        "actions has shape [", absl::StrJoin(shape, ", "), "] and type ",
        std::string(py::str(actions.dtype())), "; it is one integer for each environment")));
  }
  const auto numbers =
      py::array_t<int64_t, py::array::c_style | py::array::forcecast>::ensure(actions);
  step->mutable_actions()->Reserve(static_cast<int>(numbers.size()));
  for (py::ssize_t i = 0; i < numbers.size(); ++i) {
    const int64_t action = numbers.data()[i];
    if (action < kActionMin || action >= kActionCount) {
      Raise(absl::InvalidArgumentError(
          absl::StrCat("actions[", i, "] is ", std::string(py::str(actions[py::int_(i)])),
                       "; actions are ", kActionMin, " ... ", kActionCount - 1)));
    }
    step->add_actions(static_cast<int32_t>(action));
  }
}

template <typename Message>
void MergeSerialised(const py::bytes& serialised, Message* message) {
  const std::string_view bytes = serialised;
  if (!bytes.empty() && !message->MergeFromString(std::string(bytes))) {
    Raise(absl::InternalError("a request of this client is not a message"));
  }
}

}  // namespace

NativeStream::NativeStream(std::shared_ptr<procgen_client::Client> client,
                           std::shared_ptr<procgen_client::StepStream> stream)
    : requests_in_flight_max_(stream->requests_in_flight_max()),
      shared_batch_count_(stream->shared_batch_count()),
      held_(stream->held_batches()),
      client_(std::move(client)),
      stream_(std::move(stream)),
      shape_(ShapeOf(stream_->pool())) {}

// NOLINTNEXTLINE(bugprone-exception-escape): only without a Python interpreter
NativeStream::~NativeStream() {
  if (owner_.is_this_process()) {
    Cancel();
  } else {
    Leak(std::move(stream_));
    Leak(std::move(client_));
    static_cast<void>(receiver_.release());
  }
}

std::shared_ptr<procgen_client::StepStream> NativeStream::stream() const {
  if (stream_ == nullptr) {
    Raise(absl::CancelledError("the stream, or its connection, was closed by this client"));
  }
  return stream_;
}

int64_t NativeStream::Send(const py::bytes& request) {
  v1::StepPoolRequest message;
  MergeSerialised(request, &message);
  return SendMessage(std::move(message));
}

int64_t NativeStream::SendStep(const py::array& actions, int32_t first_env, int32_t repeat_count,
                               bool observe, bool final_observations, int32_t chunk_count,
                               const py::bytes& more) {
  v1::StepPoolRequest message;
  v1::Step* step = message.mutable_step();
  SetActions(actions, step);
  step->mutable_slice()->set_first_env(first_env);
  step->mutable_slice()->set_env_count(step->actions_size());
  step->set_repeat_count(repeat_count);
  step->set_observation(observe ? v1::OBSERVATION_FRAME : v1::OBSERVATION_NONE);
  step->set_with_final_observations(final_observations);
  step->set_chunk_count(chunk_count);
  MergeSerialised(more, step);
  return SendMessage(std::move(message));
}

int64_t NativeStream::SendMessage(v1::StepPoolRequest request) {
  const auto stream = this->stream();
  if (shared_batch_count_ != 0 && held_->count() + in_flight_ >= shared_batch_count_) {
    // Frees arrays that only reference cycles refer to.
    py::module_::import("gc").attr("collect")();
    const int32_t held = held_->count();
    if (held + in_flight_ >= shared_batch_count_) {
      Raise(absl::FailedPreconditionError(absl::StrCat(
          "arrays refer to ", held, " batches of the shared memory of ", stream->pool().name(),
          " and ", in_flight_, " requests are unanswered, of ", shared_batch_count_,
          " batches: copy observations that are kept, or make the pool with a larger "
          "held_batches_max")));
    }
  }
  const int64_t number = ValueOf(WithoutGil([&] { return stream->Send(std::move(request)); }));
  ++in_flight_;
  return number;
}

std::unique_ptr<NativeBatch> NativeStream::Receive() {
  const auto stream = this->stream();
  std::unique_ptr<procgen_client::Batch> batch = reserve_->Take();
  const absl::Status status = WithoutGil([&] { return stream->Receive(batch.get()); });
  return Received(status, std::move(batch));
}

int NativeStream::BeginReceive() {
  auto stream = this->stream();
  if (receiver_ == nullptr) {
    receiver_ = std::make_unique<NativeReceiver>(std::move(stream),
                                                 [reserve = reserve_] { return reserve->Take(); });
  }
  receiver_->Begin();
  return receiver_->event_file();
}

std::unique_ptr<NativeBatch> NativeStream::EndReceive() {
  auto [status, batch] = receiver_->Take();
  return Received(status, std::move(batch));
}

std::unique_ptr<NativeBatch> NativeStream::Received(const absl::Status& status,
                                                    std::unique_ptr<procgen_client::Batch> batch) {
  Check(status);
  --in_flight_;
  return std::make_unique<NativeBatch>(std::move(batch), reserve_, shape_,
                                       shared_batch_count_ != 0);
}

void NativeStream::Close() {
  const auto stream = this->stream();
  WithoutGil([&] { return stream->Close(); }).IgnoreError();
  Check(absl::OkStatus());
}

void NativeStream::Cancel() {
  auto stream = std::move(stream_);
  auto client = std::move(client_);
  NativeReceiver* const receiver = receiver_.get();
  if (stream != nullptr) {
    const py::gil_scoped_release released;
    stream->Abort();
    if (receiver != nullptr) {
      receiver->Stop();
    }
    stream = nullptr;
    client = nullptr;
  }
}

}  // namespace procgen_python
