#ifndef PROCGEN_CLIENT_REMOTE_POOL_H_
#define PROCGEN_CLIENT_REMOTE_POOL_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/time/time.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/frame_stack.h"
#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/pools.pb.h"
#include "procgen_client/client.h"
#include "procgen_client/open_calls.h"
#include "procgen_client/pool.h"
#include "procgen_client/run/batch_reader.h"
#include "procgen_client/run/recovering_stream.h"

namespace procgen_client {

class Servers;

struct RemotePoolOptions {
  std::string pool_id;  // last part of the pool's name; empty: chosen by the server
  procgen::v1::Encoding encoding = procgen::v1::ENCODING_RAW;
  // For people, as PoolSpec.display_name and PoolSpec.labels.
  std::string display_name;
  std::map<std::string, std::string> labels;
  RecoveryOptions recovery;  // its limits of bytes are set by Create
};

// A pool on a server, which lives as long as this object and survives broken connections and
// restarts of the server (RecoveringStream). Observations are stacked here, so frames travel once.
//
// A request that the server rejects changes nothing, and the pool continues, as one in this
// process. (A batch larger than Limits.response_bytes_max is stepped in parts: those before the
// rejected one were executed.) Any other error ends the pool: every later call returns that error.
class RemotePool final : public Pool {
 public:
  // Errors: those of Client::GetCatalog and of RunPool. `options.art` is not used.
  static procgen::StatusOr<std::unique_ptr<Pool>> Create(std::shared_ptr<Client> client,
                                                         const procgen::PoolOptions& options,
                                                         const RemotePoolOptions& remote);
  // The same on the server `home`, on the next one of `servers` whenever a server is lost, and on
  // `home` again when that is back. `servers` null: only there. `limits`: of all of them. `events`:
  // shared by pools that are stepped together.
  static procgen::StatusOr<std::unique_ptr<Pool>> Create(std::shared_ptr<Servers> servers,
                                                         std::shared_ptr<Client> home,
                                                         const procgen::v1::Limits& limits,
                                                         const procgen::PoolOptions& options,
                                                         const RemotePoolOptions& remote,
                                                         const std::shared_ptr<EventQueue>& events);
  // Waits for at most a second for the server to free the pool.
  ~RemotePool() override;

  const std::string& name() const override { return name_; }
  const procgen::PoolOptions& options() const override { return options_; }

  procgen::Status Send(const procgen::StepInput& input, absl::Span<const Annotation> annotations,
                       const procgen::Batch& batch) override;
  procgen::Status Receive(std::chrono::duration<double> timeout) override;
  int32_t unanswered_count() const override { return unanswered_count_; }

  procgen::Status SetLevelSampler(
      std::shared_ptr<const procgen::LevelSampler> level_sampler) override;
  procgen::StatusOr<std::vector<std::string>> SaveStates(
      absl::Span<const int32_t> environments) override;
  // Not all or nothing if the snapshots do not fit in one request.
  procgen::Status RestoreStates(absl::Span<const procgen::StateToRestore> states) override;
  procgen::Status CloneStates(absl::Span<const procgen::StateToClone> pairs) override;
  procgen::Status Render(int32_t environment, int32_t size_px, bool whole_level,
                         absl::Span<uint8_t> frame) override;

 private:
  // A request, or the part of one whose response would be too large.
  struct Request {
    BatchShape shape;
    bool steps = false;
    std::vector<int32_t> resets;  // environments
    procgen::Batch batch;         // the caller's memory
    bool has_finals = false;      // the server sends final observations
    bool has_frames = false;      // the server sends observations
    bool is_last = true;          // part of the caller's request
  };

  explicit RemotePool(procgen::PoolOptions options) : options_(std::move(options)) {}

  absl::Status Start();
  // Sends a part of a request.
  void SendPart(const procgen::StepInput& input, absl::Span<const Annotation> annotations,
                const procgen::Batch& batch, bool is_last);
  // Number of environments whose batch fits in a response.
  int32_t RowsMax(const procgen::Batch& batch) const;
  bool is_stacked() const { return !stacks_.empty(); }
  // As CheckIdle; also the error with which the stream has ended.
  procgen::Status CheckReady() const;
  // Sends a request and waits for its response.
  absl::StatusOr<procgen::v1::RunPoolResponse> Call(procgen::v1::RunPoolRequest request);
  absl::Status Read(const grpc::ByteBuffer& response, const BatchShape& shape,
                    const procgen::Batch& batch);
  // The arrays that the response to `request` is read into: the caller's, or own ones.
  procgen::Batch ArraysFor(const Request& request);
  // Completes the caller's arrays from those of ArraysFor.
  void Finish(const Request& request, const procgen::Batch& read);
  void StackFrames(const Request& request, const procgen::Batch& read);
  // Fills the stacks that are empty with the current frames.
  absl::Status FillStacks();

  procgen::PoolOptions options_;
  std::string name_;
  int64_t request_bytes_max_ = 0;
  int64_t response_bytes_max_ = 0;
  size_t states_per_request_ = 1;
  std::unique_ptr<RecoveringStream> stream_;
  std::optional<OpenCalls::Entry> entry_;
  std::deque<Request> unanswered_;
  int32_t unanswered_count_ = 0;  // of the caller's requests
  absl::Status part_error_;       // of a part before the next one in unanswered_
  BatchReader reader_;
  std::optional<ObservationDecoder> decoder_;  // nothing: observations are raw
  int64_t decoder_call_ = 0;                   // the call that decoder_ belongs to
  procgen::v1::Pool pool_;                     // as the server described it
  std::vector<procgen::FrameStack> stacks_;    // [N]; empty: frame_stack is 1
  // Arrays that the caller does not have.
  procgen::BatchNumbers numbers_;
  std::vector<uint8_t> frames_;
  std::vector<uint8_t> final_frames_;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_REMOTE_POOL_H_
