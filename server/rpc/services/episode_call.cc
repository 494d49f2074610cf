#include "server/rpc/services/episode_call.h"

#include <cstdint>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/wire/convert_episode.h"
#include "server/wire/enum_value.h"

namespace procgen {
namespace {

using Done = absl::AnyInvocable<void(absl::Status)>;

absl::Status Check(const v1::GetEpisodeRequest& request, const PoolSession& pool) {
  if (!v1::EpisodeSelector_IsValid(request.selector())) {
    return NoSuchValue("selector", request.selector());
  }
  if (request.environment() < 0 || request.environment() >= pool.env_count()) {
    return absl::InvalidArgumentError(
        absl::StrCat("environment is ", request.environment(), ", pool ", pool.name(),
                     " has environments 0 to ", pool.env_count() - 1));
  }
  return absl::OkStatus();
}

absl::Status Decode(const EpisodeRecording& recording, const PoolSession& pool, int32_t environment,
                    int64_t bytes_max, v1::Episode* response) {
  FillEpisode(recording.Decode(), pool.options(), environment, response);
  const auto bytes = static_cast<int64_t>(response->ByteSizeLong());
  if (bytes > bytes_max) {
    response->Clear();
    return absl::ResourceExhaustedError(absl::StrCat(
        "the episode takes ", bytes, " bytes, limit response_bytes_max is ", bytes_max));
  }
  return absl::OkStatus();
}

// Reads the recording in a turn and decodes it after the turn.
void FetchInTurn(const std::shared_ptr<PoolSession>& pool, PoolSupervisor* supervisor,
                 const v1::GetEpisodeRequest& request, v1::Episode* response, Done done) {
  auto decode = [pool, supervisor, environment = request.environment(), response,
                 done = std::move(done)](absl::StatusOr<EpisodeRecording> recording) mutable {
    pool->EndTurn();
    if (!recording.ok()) {
      done(recording.status());
      return;
    }
    supervisor->executor().Run(
        pool->owner(),
        [pool, bytes_max = supervisor->limits().response_bytes_max, environment, response,
         recording = *std::move(recording), done = std::move(done)]() mutable {
          done(Decode(recording, *pool, environment, bytes_max, response));
        });
  };
  if (request.fingerprint() != 0) {
    decode(pool->FindEpisode(request.environment(), static_cast<uint64_t>(request.fingerprint())));
  } else {
    pool->GetEpisode(request.environment(), request.selector() == v1::EPISODE_SELECTOR_CURRENT,
                     std::move(decode));
  }
}

}  // namespace

void FetchEpisode(PoolSupervisor* supervisor, const std::string& owner,
                  const v1::GetEpisodeRequest& request, v1::Episode* response, Done done) {
  const absl::StatusOr<std::shared_ptr<PoolSession>> pool = supervisor->Find(owner, request.pool());
  absl::Status status = pool.status();
  if (status.ok()) {
    status = Check(request, **pool);
  }
  if (!status.ok()) {
    done(status);
    return;
  }
  (*pool)->TakeTurn([pool = *pool, supervisor, &request, response,
                     done = std::move(done)](const absl::Status& turn) mutable {
    if (turn.ok()) {
      FetchInTurn(pool, supervisor, request, response, std::move(done));
    } else {
      done(turn);
    }
  });
}

}  // namespace procgen
