#ifndef SERVER_SESSION_BACKEND_POOL_BACKEND_H_
#define SERVER_SESSION_BACKEND_POOL_BACKEND_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/functional/any_invocable.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "server/encoding/encoding.h"
#include "server/session/backend/request.h"

namespace procgen {

// How an environment is drawn.
enum class View : uint8_t {
  kHuman,  // antialiased, as Pool::Render does
  kAgent,  // as an observation in the default format, and so at kObservationSizePx
};

// The environments of one pool, wherever they are: in this process (LocalPool), or on the nodes of
// a fleet.
//
// No call blocks. Each that ends with `done` calls it once, on any thread: also on the calling one,
// before the call returns, as a fleet does where all answers are there already. So a caller that
// makes the next call in `done` returns from there first, or its stack grows with the calls. What
// spans refer to must stay valid until `done`.
// Threads: one call at a time, on any thread; the next begins after `done`. It may go in `done`.
class PoolBackend {
 public:
  using Done = absl::AnyInvocable<void(absl::Status)>;
  // Draws what environments showed when it was made: once, on any thread, also while the pool does
  // something else or is gone. `frames`: uint8 [size_px, size_px, 3], one for each environment.
  using Draw = absl::AnyInvocable<void(const std::vector<absl::Span<uint8_t>>& frames)>;
  using CaptureDone = absl::AnyInvocable<void(absl::StatusOr<Draw>)>;
  // Is handed a snapshot of an environment; false: no more are wanted.
  using TakeState = absl::AnyInvocable<bool(int32_t environment, std::string snapshot)>;

  virtual ~PoolBackend() = default;

  // It was deleted, or its lease has run out: what is kept of it beyond this process need not be
  // kept any longer. Threads: any, at any time.
  virtual void Discard() {}

  virtual const PoolOptions& options() const = 0;
  int32_t env_count() const { return options().env_count; }
  // Whether the episode of `environment` has ended and it must be reset before it is stepped, with
  // AutoresetMode::kDisabled. REQUIRES: an index in the pool, and that no call runs.
  virtual bool AwaitsReset(int32_t environment) const = 0;

  // Tells a whole request before its parts are carried out, from the first to the last, so that who
  // is far away can begin with all of it. `first_part`: no part asks for arrays that this one has
  // not. `request` must stay valid until its last part is done, or one has failed.
  virtual void BeginRequest(const Request& request, const Batch& first_part) = 0;
  // As Pool::StepAsync, of a part of the request that has begun.
  virtual void StepAsync(const StepInput& part, const Batch& batch, Done done) = 0;
  // As those of Pool.
  virtual void SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler, Done done) = 0;
  virtual void SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) = 0;
  virtual void RestoreStates(std::vector<StateToRestore> states, Done done) = 0;
  virtual void CloneStates(std::vector<StateToClone> pairs, Done done) = 0;
  // What environments show, to be drawn later at a size, in `view`. An environment may be named
  // several times.
  virtual void CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                             CaptureDone done) = 0;
};

// How a pool is kept, and how its batches travel, besides what it is made of.
struct SessionOptions {
  absl::Duration lease_duration = absl::InfiniteDuration();  // its life without a stream
  Encoding encoding = Encoding::kRaw;
  // Batches are written where learners map them; then as they are drawn.
  bool shares_memory = false;
};

// A pool that is to be made.
struct CreatePoolOptions {
  std::string owner;
  std::string name;
  PoolOptions options;
  SessionOptions session_options;
};

// A pool that goes on where an earlier process had it.
struct ResumedPool {
  CreatePoolOptions create_options;
  std::unique_ptr<PoolBackend> pool;
  int64_t next_sequence_number = 1;
  // The last requests that were accepted, serialised as they were sent. The pool stands before the
  // first of them; whoever has it carries them out `again`, since learners may ask for the answers.
  std::vector<std::string> requests;
};

// Where the pools of a server are made. Threads: any method from any thread.
class PoolBackendFactory {
 public:
  using CreateDone = absl::AnyInvocable<void(absl::StatusOr<std::unique_ptr<PoolBackend>>)>;

  virtual ~PoolBackendFactory() = default;

  // Makes a pool and calls `done` once, on any thread. Errors: those of Pool::Create, and what
  // keeps the backend from having it.
  virtual void Create(const CreatePoolOptions& create_options, CreateDone done) = 0;
  // The pools that earlier processes left here; once.
  virtual std::vector<ResumedPool> TakeResumed() { return {}; }
  // Whether its pools outlive the process: the next one has them, and learners need but wait for
  // it.
  virtual bool keeps_pools() const { return false; }
  // Threads that step environments.
  virtual int32_t worker_count() const = 0;
};

}  // namespace procgen

#endif  // SERVER_SESSION_BACKEND_POOL_BACKEND_H_
