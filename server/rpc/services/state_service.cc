#include "server/rpc/services/state_service.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/rpc/call/unary_call.h"
#include "server/rpc/services/remote_states.h"
#include "server/rpc/services/states_page.h"
#include "server/session/backend/environment_list.h"
#include "server/wire/convert_episode.h"
#include "server/wire/enum_value.h"
#include "server/wire/response_limit.h"

namespace procgen {
namespace {

// Largest length of an address. A host name has at most 255 characters, a socket path 108.
constexpr size_t kServerLengthMax = 512;

using SaveCall = UnaryCall<v1::SaveStatesRequest, v1::SaveStatesResponse>;
using RestoreCall = UnaryCall<v1::RestoreStatesRequest, v1::RestoreStatesResponse>;
using EpisodeCall = UnaryCall<v1::GetEpisodeRequest, v1::Episode>;
using CloneCall = UnaryCall<v1::CloneStatesRequest, v1::CloneStatesResponse>;
// Shared by the registry and the calls in progress, because a pool may be deleted meanwhile.
using SharedPool = std::shared_ptr<PoolSession>;
using Snapshots = std::vector<std::string>;

// Takes a turn of `pool` and calls `begin` in it, or ends `call` with an error.
template <typename Call, typename Begin>
void InTurn(const SharedPool& pool, Call* call, Begin begin) {
  pool->TakeTurn([pool, call, begin = std::move(begin)](const absl::Status& turn) mutable {
    if (turn.ok()) {
      begin();
    } else {
      call->Finish(turn);
    }
  });
}

// Returns a callback that ends the turn and the call.
template <typename Call>
PoolSession::Done EndOf(const SharedPool& pool, Call* call) {
  return [pool, call](const absl::Status& status) {
    pool->EndTurn();
    call->Finish(status);
  };
}

// Fills a page within a turn, then ends the turn and the call.
void SavePage(const SharedPool& pool, std::unique_ptr<StatesPage> page, SaveCall* call) {
  if (absl::Status status = page->Open(pool->change_number()); !status.ok()) {
    pool->EndTurn();
    call->Finish(status);
    return;
  }
  call->response()->set_sequence_number(pool->next_sequence_number() - 1);
  StatesPage* filled = page.get();
  pool->SaveStates(
      filled->rest(),
      [filled, call](int32_t environment, std::string snapshot) {
        return filled->Add(environment, std::move(snapshot), call->response());
      },
      [pool, page = std::move(page), call](absl::Status status) {
        pool->EndTurn();
        call->Finish(status.ok() ? page->Close(call->response()) : std::move(status));
      });
}

// The environments of a CloneStates request.
struct ClonedEnvironments {
  std::vector<int32_t> targets;  // of each pair
  std::vector<int32_t> sources;  // of each pair
  std::vector<int32_t> saved;    // the sources, sorted, each once
};

ClonedEnvironments EnvironmentsOf(const v1::CloneStatesRequest& request) {
  ClonedEnvironments environments;
  for (const v1::ClonePair& pair : request.pairs()) {
    environments.targets.push_back(pair.target_environment());
    environments.sources.push_back(pair.source_environment());
  }
  environments.saved = environments.sources;
  std::sort(environments.saved.begin(), environments.saved.end());
  environments.saved.erase(std::unique(environments.saved.begin(), environments.saved.end()),
                           environments.saved.end());
  return environments;
}

// Restores the targets from the snapshots of `environments.saved` in a turn, then ends the call.
void RestoreTargets(const SharedPool& target, const ClonedEnvironments& environments,
                    absl::StatusOr<Snapshots> snapshots, CloneCall* call) {
  if (!snapshots.ok()) {
    call->Finish(snapshots.status());
    return;
  }
  std::vector<StateToRestore> states;
  states.reserve(environments.targets.size());
  for (size_t i = 0; i < environments.targets.size(); ++i) {
    const auto saved = std::lower_bound(environments.saved.begin(), environments.saved.end(),
                                        environments.sources[i]);
    states.push_back(
        {.environment = environments.targets[i],
         .snapshot = (*snapshots)[static_cast<size_t>(saved - environments.saved.begin())]});
  }
  // `states` points into the snapshots, which moving the vector does not move.
  // NOLINTBEGIN(clang-analyzer-cplusplus.NewDeleteLeaks): the analyser loses a shared pointer
  InTurn(target, call,
         [target, states = std::move(states), owner = *std::move(snapshots), call]() mutable {
           target->RestoreStates(std::move(states),
                                 [owner = std::move(owner), end = EndOf(target, call)](
                                     absl::Status status) mutable { end(std::move(status)); });
         });
  // NOLINTEND(clang-analyzer-cplusplus.NewDeleteLeaks)
}

// Clones within a pool, in one turn.
void CloneWithin(const SharedPool& pool, const ClonedEnvironments& environments, CloneCall* call) {
  std::vector<StateToClone> pairs;
  pairs.reserve(environments.targets.size());
  for (size_t i = 0; i < environments.targets.size(); ++i) {
    pairs.push_back({.source_environment = environments.sources[i],
                     .target_environment = environments.targets[i]});
  }
  InTurn(pool, call, [pool, pairs = std::move(pairs), call]() mutable {
    pool->CloneStates(std::move(pairs), EndOf(pool, call));
  });
}

// The snapshots that a clone between two pools has saved so far.
struct Saved {
  ClonedEnvironments environments;
  Snapshots snapshots;
};

// Clones from another pool of this server: takes a turn of the source, then one of the target.
void CloneFrom(const SharedPool& source, const SharedPool& target, ClonedEnvironments environments,
               CloneCall* call) {
  InTurn(source, call, [source, target, environments = std::move(environments), call]() mutable {
    auto saved = std::make_unique<Saved>();
    saved->environments = std::move(environments);
    Saved* filled = saved.get();
    source->SaveStates(
        filled->environments.saved,
        [filled](int32_t /*environment*/, std::string snapshot) {
          filled->snapshots.push_back(std::move(snapshot));
          return true;
        },
        [source, target, saved = std::move(saved), call](const absl::Status& status) {
          source->EndTurn();
          if (status.ok()) {
            RestoreTargets(target, saved->environments, std::move(saved->snapshots), call);
          } else {
            call->Finish(status);
          }
        });
  });
}

// Parses and checks the address of a source server.
absl::StatusOr<Address> SourceAddress(const std::string& server,
                                      const CloneSourceAllowlist& allowlist) {
  if (server.size() > kServerLengthMax) {
    return absl::InvalidArgumentError(absl::StrCat(
        "source_server has ", server.size(), " characters, allowed: at most ", kServerLengthMax));
  }
  absl::StatusOr<Address> address = ParseAddress(server);
  if (!address.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "source_server is '", server, "', allowed: 'HOST:PORT', '[IPV6]:PORT' or 'unix:PATH'"));
  }
  if (!allowlist.Allows(*address)) {
    return absl::PermissionDeniedError(
        absl::StrCat("source_server is ", server,
                     ", which this server may not connect to; its operator allows "
                     "sources with --clone_source_allowlist"));
  }
  return address;
}

// Clones from a pool of another server. No turn is held while fetching.
void CloneFromServer(const grpc::CallbackServerContext& context,
                     const CloneSourceAllowlist& allowlist, const SharedPool& target,
                     ClonedEnvironments environments, CloneCall* call) {
  const v1::CloneStatesRequest& request = call->request();
  const absl::StatusOr<Address> address = SourceAddress(request.source_server(), allowlist);
  if (!address.ok()) {
    call->Finish(address.status());
    return;
  }
  RemoteEnvironments source;
  source.address = *address;
  source.server = request.source_server();
  source.pool = request.source_pool().empty() ? target->name() : request.source_pool();
  source.environments = environments.saved;
  FetchRemoteStates(
      context, std::move(source),
      [target, environments = std::move(environments), call](absl::StatusOr<Snapshots> snapshots) {
        RestoreTargets(target, environments, std::move(snapshots), call);
      });
}

void Clone(const PoolSupervisor& supervisor, const CloneSourceAllowlist& allowlist,
           const grpc::CallbackServerContext& context, CloneCall* call) {
  const v1::CloneStatesRequest& request = call->request();
  ClonedEnvironments environments = EnvironmentsOf(request);
  const absl::StatusOr<SharedPool> target = supervisor.Find(call->owner(), request.pool());
  absl::Status status = target.status();
  if (status.ok()) {
    status = CheckEnvironmentList(
        {.list = "pairs", .member = ".target_environment", .environments = environments.targets},
        (*target)->name(), (*target)->env_count());
  }
  if (status.ok() && !request.source_server().empty()) {
    CloneFromServer(context, allowlist, *target, std::move(environments), call);
    return;
  }
  absl::StatusOr<SharedPool> source = target;
  if (status.ok() && !request.source_pool().empty()) {
    source = supervisor.Find(call->owner(), request.source_pool());
    status = source.status();
  }
  if (status.ok()) {
    status = CheckEnvironmentList({.list = "pairs",
                                   .member = ".source_environment",
                                   .environments = environments.sources,
                                   .repeats_allowed = true},
                                  (*source)->name(), (*source)->env_count());
  }
  if (!status.ok()) {
    call->Finish(status);
  } else if (*source == *target) {
    CloneWithin(*target, environments, call);
  } else {
    CloneFrom(*source, *target, std::move(environments), call);
  }
}

absl::Status CheckGetEpisode(const v1::GetEpisodeRequest& request, const PoolSession& pool) {
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

// Decodes an episode and ends the call with it.
void FinishEpisode(const EpisodeRecording& recording, const PoolSession& pool, int64_t bytes_max,
                   EpisodeCall* call) {
  FillEpisode(recording.Decode(), pool.options(), call->request().environment(), call->response());
  const auto bytes = static_cast<int64_t>(call->response()->ByteSizeLong());
  if (bytes > bytes_max) {
    call->Finish(absl::ResourceExhaustedError(absl::StrCat(
        "the episode takes ", bytes, " bytes, limit response_bytes_max is ", bytes_max)));
    return;
  }
  call->Finish(absl::OkStatus());
}

// Copies the recording of an episode in a turn and decodes it after the turn.
void FetchEpisode(const SharedPool& pool, int64_t bytes_max, BackgroundExecutor* executor,
                  EpisodeCall* call) {
  const v1::GetEpisodeRequest& request = call->request();
  call->response()->set_sequence_number(pool->next_sequence_number() - 1);
  auto finish = [pool, bytes_max, executor, call](absl::StatusOr<EpisodeRecording> recording) {
    pool->EndTurn();
    if (!recording.ok()) {
      call->Finish(recording.status());
      return;
    }
    executor->Run(call->owner(), [pool, bytes_max, call, recording = *std::move(recording)] {
      FinishEpisode(recording, *pool, bytes_max, call);
    });
  };
  if (request.fingerprint() != 0) {
    finish(pool->FindEpisode(request.environment(), static_cast<uint64_t>(request.fingerprint())));
  } else {
    pool->GetEpisode(request.environment(), request.selector() == v1::EPISODE_SELECTOR_CURRENT,
                     std::move(finish));
  }
}

}  // namespace

StateServiceImpl::StateServiceImpl(PoolSupervisor* supervisor, const CallAccounting* accounting,
                                   CloneSourceAllowlist clone_source_allowlist)
    : supervisor_(supervisor),
      accounting_(accounting),
      clone_source_allowlist_(std::move(clone_source_allowlist)) {
  AddByteMethod<v1::SaveStatesRequest>([this](auto* context) { return SaveStates(context); });
  AddByteMethod<v1::RestoreStatesRequest>([this](auto* context) { return RestoreStates(context); });
  AddByteMethod<v1::CloneStatesRequest>([this](auto* context) { return CloneStates(context); });
  AddByteMethod<v1::GetEpisodeRequest>([this](auto* context) { return GetEpisode(context); });
}

ByteStream* StateServiceImpl::SaveStates(grpc::CallbackServerContext* context) {
  return SaveCall::Start(*accounting_, *context, [this](SaveCall* call) {
    const absl::StatusOr<SharedPool> pool =
        supervisor_->Find(call->owner(), call->request().pool());
    if (!pool.ok()) {
      call->Finish(pool.status());
      return;
    }
    auto page = StatesPage::Begin(call->request(), **pool, supervisor_->limits());
    if (!page.ok()) {
      call->Finish(page.status());
      return;
    }
    InTurn(*pool, call, [pool = *pool, page = *std::move(page), call]() mutable {
      SavePage(pool, std::move(page), call);
    });
  });
}

ByteStream* StateServiceImpl::RestoreStates(grpc::CallbackServerContext* context) {
  return RestoreCall::Start(*accounting_, *context, [this](RestoreCall* call) {
    const absl::StatusOr<SharedPool> pool =
        supervisor_->Find(call->owner(), call->request().pool());
    std::vector<int32_t> environments;
    std::vector<StateToRestore> states;
    for (const v1::State& state : call->request().states()) {
      environments.push_back(state.environment());
      states.push_back({.environment = state.environment(), .snapshot = state.snapshot()});
    }
    absl::Status status = pool.status();
    if (status.ok()) {
      status = CheckEnvironmentList(
          {.list = "states", .member = ".environment", .environments = environments},
          (*pool)->name(), (*pool)->env_count());
    }
    if (!status.ok()) {
      call->Finish(status);
      return;
    }
    InTurn(*pool, call, [pool = *pool, states = std::move(states), call]() mutable {
      pool->RestoreStates(std::move(states), EndOf(pool, call));
    });
  });
}

ByteStream* StateServiceImpl::CloneStates(grpc::CallbackServerContext* context) {
  return CloneCall::Start(*accounting_, *context, [this, context](CloneCall* call) {
    Clone(*supervisor_, clone_source_allowlist_, *context, call);
  });
}

ByteStream* StateServiceImpl::GetEpisode(grpc::CallbackServerContext* context) {
  return EpisodeCall::Start(*accounting_, *context, [this](EpisodeCall* call) {
    const absl::StatusOr<SharedPool> pool =
        supervisor_->Find(call->owner(), call->request().pool());
    absl::Status status = pool.status();
    if (status.ok()) {
      status = CheckGetEpisode(call->request(), **pool);
    }
    const absl::StatusOr<int64_t> bytes_max = ResponseBytesMax(
        "response_bytes_max", call->request().response_bytes_max(), supervisor_->limits());
    status.Update(bytes_max.status());
    if (!status.ok()) {
      call->Finish(status);
      return;
    }
    InTurn(*pool, call, [this, pool = *pool, bytes_max = *bytes_max, call] {
      FetchEpisode(pool, bytes_max, &supervisor_->executor(), call);
    });
  });
}

}  // namespace procgen
