#include "server/fleet/nodes/node_answers.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "server/fleet/log/shard_request.h"

namespace procgen {
namespace {

// Maximum size of a snapshot, in bytes.
constexpr size_t kSnapshotBytesMax = 1 << 20;

absl::Status Wrong(absl::string_view what, absl::string_view answered, absl::string_view expected) {
  return absl::DataLossError(absl::StrCat(what, " is ", answered, ", expected: ", expected));
}

absl::Status CheckAtLeast(absl::string_view what, int64_t answered, int64_t least) {
  return answered >= least ? absl::OkStatus()
                           : Wrong(what, absl::StrCat(answered), absl::StrCat(least, " or more"));
}

absl::Status CheckEqual(absl::string_view what, int64_t answered, int64_t expected) {
  return answered == expected ? absl::OkStatus()
                              : Wrong(what, absl::StrCat(answered), absl::StrCat(expected));
}

template <typename Element>
absl::Status CheckSize(absl::string_view what, absl::Span<const Element> array, size_t expected) {
  return array.size() == expected ? absl::OkStatus()
                                  : Wrong(absl::StrCat("the size of batch.", what),
                                          absl::StrCat(array.size()), absl::StrCat(expected));
}

}  // namespace

bool IsNodeError(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kDataLoss:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnimplemented:
      return false;
    default:
      return true;
  }
}

absl::Status CheckNodeLimits(const v1::Limits& limits) {
  absl::Status status =
      CheckAtLeast("limits.requests_in_flight_max", limits.requests_in_flight_max(), 1);
  status.Update(CheckAtLeast("limits.response_bytes_max", limits.response_bytes_max(), 1));
  status.Update(CheckAtLeast("limits.request_bytes_max", limits.request_bytes_max(), 1));
  status.Update(
      CheckAtLeast("limits.lease_duration_max.seconds", limits.lease_duration_max().seconds(), 1));
  return status;
}

absl::Status CheckNodePool(const v1::Pool& pool, const v1::PoolSpec& spec,
                           const std::string& pool_id) {
  const std::string name = absl::StrCat("pools/", pool_id);
  if (pool.name() != name) {
    return Wrong("pool.name", absl::StrCat(pool.name().size(), " other characters"), name);
  }
  absl::Status status =
      CheckEqual("pool.spec.env_count", pool.spec().env_count(), spec.env_count());
  status.Update(CheckEqual("pool.spec.first_env", pool.spec().first_env(), spec.first_env()));
  status.Update(CheckEqual("pool.spec.total_env_count", pool.spec().total_env_count(),
                           spec.total_env_count()));
  return status;
}

absl::Status CheckNodeStream(const procgen_client::StepStream& stream, int32_t env_count,
                             int32_t requests_in_flight_max) {
  absl::Status status = CheckEqual("attached.pool.spec.env_count", stream.env_count(), env_count);
  status.Update(CheckEqual("attached.requests_in_flight_max", stream.requests_in_flight_max(),
                           requests_in_flight_max));
  if (status.ok() && stream.pool().spec().transport() == v1::TRANSPORT_SHARED_MEMORY) {
    status = Wrong("attached.pool.spec.transport", "TRANSPORT_SHARED_MEMORY", "TRANSPORT_STREAM");
  }
  return status;
}

RequestedRows AskedRowsOf(const v1::StepPoolRequest& request) {
  RequestedRows asked;
  asked.slice = SliceOf(request, 0);
  if (request.has_step()) {
    asked.observations = request.step().observation() != v1::OBSERVATION_NONE;
    asked.final_observations = request.step().with_final_observations();
  } else if (request.has_reset()) {
    asked.observations = request.reset().observation() != v1::OBSERVATION_NONE;
  } else {
    asked.observations = request.observe().observation() != v1::OBSERVATION_NONE;
  }
  return asked;
}

absl::Status CheckNodeBatch(const procgen_client::Batch& batch, const RequestedRows& asked,
                            size_t observation_bytes) {
  absl::Status status = CheckEqual("batch.first_env", batch.first_env(), asked.slice.first);
  status.Update(CheckEqual("batch.env_count", batch.env_count(), asked.slice.count));
  if (!status.ok()) {
    return status;
  }
  const auto rows = static_cast<size_t>(batch.env_count());
  status.Update(CheckSize("rewards", batch.rewards(), rows));
  status.Update(CheckSize("first", batch.first(), rows));
  status.Update(CheckSize("terminated", batch.terminated(), rows));
  status.Update(CheckSize("truncated", batch.truncated(), rows));
  status.Update(CheckSize("level_seeds", batch.level_seeds(), rows));
  status.Update(CheckSize("prev_level_seeds", batch.prev_level_seeds(), rows));
  status.Update(CheckSize("prev_level_complete", batch.prev_level_complete(), rows));
  status.Update(CheckSize("episode_returns", batch.episode_returns(), rows));
  status.Update(CheckSize("episode_lengths", batch.episode_lengths(), rows));
  status.Update(CheckSize("observations", batch.observations(),
                          asked.observations ? rows * observation_bytes : 0));
  if (!status.ok()) {
    return status;
  }
  size_t ended = 0;
  for (size_t row = 0; row < rows; ++row) {
    ended += batch.terminated()[row] || batch.truncated()[row] ? 1 : 0;
  }
  status.Update(CheckSize("fingerprints", batch.fingerprints(), ended));
  status.Update(CheckSize("final_observations", batch.final_observations(),
                          asked.final_observations ? ended * observation_bytes : 0));
  return status;
}

absl::StatusOr<std::vector<std::string>> TakeNodeStates(std::vector<v1::State> states,
                                                        absl::Span<const int32_t> environments,
                                                        int32_t env_count) {
  const size_t count = environments.empty() ? static_cast<size_t>(env_count) : environments.size();
  if (states.size() != count) {
    return Wrong("the number of states", absl::StrCat(states.size()), absl::StrCat(count));
  }
  std::vector<std::string> snapshots;
  snapshots.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    const int32_t expected = environments.empty() ? static_cast<int32_t>(i) : environments[i];
    absl::Status status =
        CheckEqual(absl::StrCat("states[", i, "].environment"), states[i].environment(), expected);
    const size_t bytes = states[i].snapshot().size();
    if (status.ok() && (bytes == 0 || bytes > kSnapshotBytesMax)) {
      status = Wrong(absl::StrCat("the size of states[", i, "].snapshot"), absl::StrCat(bytes),
                     absl::StrCat("1 to ", kSnapshotBytesMax));
    }
    if (!status.ok()) {
      return status;
    }
    snapshots.push_back(std::move(*states[i].mutable_snapshot()));
  }
  return snapshots;
}

absl::Status CheckNodeFrame(const v1::RenderEnvironmentsResponse& response, size_t bytes) {
  absl::Status status = CheckEqual("the number of frames", response.frames_size(), 1);
  if (status.ok()) {
    status = CheckEqual("the size of frames[0].image",
                        static_cast<int64_t>(response.frames(0).image().size()),
                        static_cast<int64_t>(bytes));
  }
  return status;
}

}  // namespace procgen
