#ifndef PROCGEN_CLIENT_SHARDED_POOL_H_
#define PROCGEN_CLIENT_SHARDED_POOL_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "procgen_client/client.h"
#include "procgen_client/pool.h"
#include "procgen_client/remote_pool.h"
#include "procgen_client/servers.h"

namespace procgen_client {

// A pool whose environments are spread over several servers, in slices by their threads and load.
// Results equal those of one server, bit for bit. The slice of a server that is lost continues on
// another one, and returns to it when it is back. No server knows of the others.
class ShardedPool final : public Pool {
 public:
  // Servers that do not answer within two seconds get no slice; a later loss may still move one
  // there. Errors: UNAVAILABLE none answers; those of RemotePool::Create.
  static procgen::StatusOr<std::unique_ptr<Pool>> Create(const std::shared_ptr<Servers>& servers,
                                                         const procgen::PoolOptions& options,
                                                         const RemotePoolOptions& remote);

  // The names of its slices, joined by commas.
  const std::string& name() const override { return name_; }
  const procgen::PoolOptions& options() const override { return options_; }

  procgen::Status Send(const procgen::StepInput& input, absl::Span<const Annotation> annotations,
                       const procgen::Batch& batch) override;
  // After an error of one slice, the others have executed the request.
  procgen::Status Receive(std::chrono::duration<double> timeout) override;
  int32_t unanswered_count() const override { return static_cast<int32_t>(unanswered_.size()); }

  procgen::Status SetLevelSampler(
      std::shared_ptr<const procgen::LevelSampler> level_sampler) override;
  procgen::StatusOr<std::vector<std::string>> SaveStates(
      absl::Span<const int32_t> environments) override;
  procgen::Status RestoreStates(absl::Span<const procgen::StateToRestore> states) override;
  procgen::Status CloneStates(absl::Span<const procgen::StateToClone> pairs) override;
  procgen::Status Render(int32_t environment, int32_t size_px, bool whole_level,
                         absl::Span<uint8_t> frame) override;

 private:
  // A request under way.
  struct Request {
    std::deque<size_t> asked;  // shards that have not answered yet
    procgen::Status error;     // the first one so far
  };
  struct Shard {
    int32_t first = 0;  // its environments in this pool: [first, first + count)
    int32_t count = 0;
    std::unique_ptr<Pool> pool;
  };

  explicit ShardedPool(procgen::PoolOptions options) : options_(std::move(options)) {}

  // Whether `environment` is in the pool. Errors: INVALID_ARGUMENT.
  procgen::Status CheckEnvironment(int32_t environment) const;
  Shard& ShardOf(int32_t environment);

  procgen::PoolOptions options_;
  std::string name_;
  std::vector<Shard> shards_;
  std::deque<Request> unanswered_;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_SHARDED_POOL_H_
