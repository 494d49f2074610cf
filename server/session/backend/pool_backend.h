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
  kLevel,  // as kHuman, with the whole level
};

// The environments of one pool: in this process (LocalPool), or on the nodes of a fleet.
//
// No call blocks. Each call with a `done` calls it once, on any thread. That may be the calling
// thread, before the call returns; a fleet does so when all answers have arrived. A caller that
// starts the next call in `done` must first return from it, or its stack grows with the calls.
// Memory that spans refer to must stay valid until `done`.
// Threads: one call at a time, from any thread. The next call may begin in `done`.
class PoolBackend {
 public:
  using Done = absl::AnyInvocable<void(absl::Status)>;
  // Draws the captured scenes. Call once, on any thread; the pool may be busy or destroyed by then.
  // `frames`: uint8 [size_px, size_px, 3], one for each captured environment.
  using Draw = absl::AnyInvocable<void(const std::vector<absl::Span<uint8_t>>& frames)>;
  using CaptureDone = absl::AnyInvocable<void(absl::StatusOr<Draw>)>;
  // Receives a snapshot of an environment. Returns false to stop.
  using TakeState = absl::AnyInvocable<bool(int32_t environment, std::string snapshot)>;

  virtual ~PoolBackend() = default;

  // The pool was deleted or its lease expired: data stored outside this process may be deleted.
  // Threads: any, at any time.
  virtual void Discard() {}

  virtual const PoolOptions& options() const = 0;
  int32_t env_count() const { return options().env_count; }
  // Whether the episode of `environment` has ended and it must be reset before the next step, with
  // AutoresetMode::kDisabled. REQUIRES: an index in the pool, and no call in progress.
  virtual bool AwaitsReset(int32_t environment) const = 0;

  // Announces a whole request before its parts are executed in order. A remote backend can then
  // start on all of it at once. `first_part`: no part asks for an array that this one does not
  // have. `request` must stay valid until its last part is done or one has failed.
  virtual void BeginRequest(const Request& request, const Batch& first_part) = 0;
  // As Pool::StepAsync, for one part of the request passed to BeginRequest.
  virtual void StepAsync(const StepInput& part, const Batch& batch, Done done) = 0;
  // As the methods of Pool.
  virtual void SetLevelSampler(std::shared_ptr<const LevelSampler> level_sampler, Done done) = 0;
  virtual void SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) = 0;
  virtual void RestoreStates(std::vector<StateToRestore> states, Done done) = 0;
  virtual void CloneStates(std::vector<StateToClone> pairs, Done done) = 0;
  // Captures the scenes of environments, to be drawn later at `size_px` in `view`. An environment
  // may be listed several times.
  virtual void CaptureScenes(const std::vector<int32_t>& environments, View view, int32_t size_px,
                             CaptureDone done) = 0;
};

// Options of a pool that concern its session, not its environments.
struct SessionOptions {
  absl::Duration lease_duration = absl::InfiniteDuration();  // lifetime without a stream
  Encoding encoding = Encoding::kRaw;
  // Batches are written to memory that learners map; they are then not encoded.
  bool shares_memory = false;
};

// The arguments of PoolBackendFactory::Create.
struct CreatePoolOptions {
  std::string owner;
  std::string name;
  PoolOptions options;
  SessionOptions session_options;
};

// A pool of an earlier process that is continued in this one.
struct ResumedPool {
  CreatePoolOptions create_options;
  std::unique_ptr<PoolBackend> pool;
  int64_t next_sequence_number = 1;
  // The last accepted requests, serialised as they were sent. The pool is in the state before the
  // first of them. The owner of the pool executes them with `again` set, since learners may request
  // their answers.
  std::vector<std::string> requests;
};

// Creates the pools of a server. Threads: any method from any thread.
class PoolBackendFactory {
 public:
  using CreateDone = absl::AnyInvocable<void(absl::StatusOr<std::unique_ptr<PoolBackend>>)>;

  virtual ~PoolBackendFactory() = default;

  // Creates a pool and calls `done` once, on any thread. Errors: those of Pool::Create and of the
  // backend.
  virtual void Create(const CreatePoolOptions& create_options, CreateDone done) = 0;
  // The pools of earlier processes. Call once.
  virtual std::vector<ResumedPool> TakeResumed() { return {}; }
  // Whether pools outlive the process. If so, the next process resumes them and learners only have
  // to wait for it.
  virtual bool keeps_pools() const { return false; }
  // Number of threads that step environments.
  virtual int32_t worker_count() const = 0;
};

}  // namespace procgen

#endif  // SERVER_SESSION_BACKEND_POOL_BACKEND_H_
