#include "server/rpc/step/attach.h"

#include <algorithm>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "server/logging/event_log.h"
#include "server/net/address.h"
#include "server/wire/convert_pool.h"
#include "server/wire/convert_shared.h"
#include "server/wire/response_limit.h"

namespace procgen {
namespace {

absl::StatusOr<int32_t> RequestsInFlightMax(int32_t asked, const Limits& limits) {
  if (asked > limits.requests_in_flight_max) {
    return absl::ResourceExhaustedError(absl::StrCat("attach.requests_in_flight_max is ", asked,
                                                     ", limit requests_in_flight_max is ",
                                                     limits.requests_in_flight_max));
  }
  if (asked < 0) {
    return absl::InvalidArgumentError(absl::StrCat("attach.requests_in_flight_max is ", asked,
                                                   ", allowed: 0 to ",
                                                   limits.requests_in_flight_max));
  }
  return asked == 0 ? std::min(kRequestsInFlightDefault, limits.requests_in_flight_max) : asked;
}

using AttachDone = absl::AnyInvocable<void(absl::StatusOr<Attachment>)>;

absl::Status CheckCanShare(const PoolSession& pool, const std::string& peer) {
  if (pool.shared_batch_slots() == nullptr || IsOnThisMachine(peer)) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(absl::StrCat(
      "pool ", pool.name(), " has TRANSPORT_SHARED_MEMORY and the learner is at ", peer,
      ", allowed: on the server's machine, by loopback or a unix socket; otherwise "
      "make a pool with TRANSPORT_STREAM"));
}

// Completes an attach: reports the attachment, or detaches after an error.
void EndAttach(const PoolSupervisor* supervisor, Attachment attachment, absl::Status status,
               AttachDone done) {
  if (status.ok() && supervisor->draining()) {
    status = supervisor->Draining();  // the drain may have ended all streams before this one
  }
  if (!status.ok()) {
    attachment.pool->Detach();
    done(std::move(status));
    return;
  }
  const PoolSession& pool = *attachment.pool;
  supervisor->metrics().AddStream(attachment.stream_options.attach.resumable &&
                                  pool.next_sequence_number() > 1);
  LogEvent(LogLevel::kInfo, "stream_attached",
           {{"pool", pool.name()},
            {"owner", pool.owner()},
            {"next_sequence_number", absl::StrCat(pool.next_sequence_number())}});
  done(std::move(attachment));
}

}  // namespace

absl::StatusOr<StreamOptions> ReadAttach(const v1::StepPoolRequest& request, const Limits& limits) {
  if (!request.has_attach()) {
    return absl::InvalidArgumentError(
        "the first request of a stream has no attach; name the pool there");
  }
  if (request.sequence_number() != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("sequence_number is ", request.sequence_number(), " with attach, allowed: 0"));
  }
  if (request.released_batches_size() > 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "released_batches has ", request.released_batches_size(),
        " entries with attach, allowed: none; list the unreleased ones in held_batches"));
  }
  const v1::Attach& attach = request.attach();
  if (attach.held_batches_max() < 0 || attach.held_batches_max() > kHeldBatchesMax) {
    return absl::InvalidArgumentError(absl::StrCat("attach.held_batches_max is ",
                                                   attach.held_batches_max(), ", allowed: 0 to ",
                                                   kHeldBatchesMax));
  }
  const absl::StatusOr<int32_t> in_flight =
      RequestsInFlightMax(attach.requests_in_flight_max(), limits);
  if (!in_flight.ok()) {
    return in_flight.status();
  }
  const absl::StatusOr<int64_t> response_bytes_max =
      ResponseBytesMax("attach.response_bytes_max", attach.response_bytes_max(), limits);
  if (!response_bytes_max.ok()) {
    return response_bytes_max.status();
  }
  StreamOptions stream_options;
  stream_options.attach.requests_in_flight_max = *in_flight;
  stream_options.attach.resumable = attach.resumable();
  stream_options.attach.take_over = attach.take_over();
  stream_options.attach.held_batches_max = attach.held_batches_max();
  stream_options.attach.held_batches.assign(attach.held_batches().begin(),
                                            attach.held_batches().end());
  stream_options.response_bytes_max = *response_bytes_max;
  return stream_options;
}

void AttachStream(const PoolSupervisor* supervisor, const Learner& learner,
                  const v1::StepPoolRequest& request, PoolSession::EndStream end_stream,
                  absl::AnyInvocable<void(absl::StatusOr<Attachment>)> done) {
  const absl::StatusOr<StreamOptions> stream_options = ReadAttach(request, supervisor->limits());
  if (!stream_options.ok()) {
    done(stream_options.status());
    return;
  }
  const absl::StatusOr<std::shared_ptr<PoolSession>> pool =
      supervisor->FindForStream(learner.owner, request.attach().pool());
  const absl::Status status = pool.ok() ? CheckCanShare(**pool, learner.peer) : pool.status();
  if (!status.ok()) {
    done(status);
    return;
  }
  (*pool)->Attach(
      stream_options->attach, std::move(end_stream),
      [supervisor, attachment = Attachment{*pool, *stream_options},
       done = std::move(done)](absl::Status attached) mutable {
        if (!attached.ok()) {
          done(std::move(attached));
          return;
        }
        PoolSession* const session = attachment.pool.get();
        const AttachOptions options = attachment.stream_options.attach;
        session->ShareMemory(options, [supervisor, attachment = std::move(attachment),
                                       done = std::move(done)](absl::Status shared) mutable {
          EndAttach(supervisor, std::move(attachment), std::move(shared), std::move(done));
        });
      });
}

void FillAttached(const PoolSession& pool, const StreamOptions& stream_options,
                  v1::StepPoolResponse* response) {
  response->set_sequence_number(0);
  v1::Attached* attached = response->mutable_attached();
  *attached->mutable_pool() = PoolMessageOf(pool);
  attached->set_next_sequence_number(pool.next_sequence_number());
  attached->set_oldest_kept_sequence_number(pool.oldest_kept_sequence_number());
  attached->set_response_bytes_max(stream_options.response_bytes_max);
  attached->set_requests_in_flight_max(stream_options.attach.requests_in_flight_max);
  if (pool.shared_batch_slots() != nullptr) {
    FillSharedMemory(pool, attached->mutable_shared_memory());
  }
}

}  // namespace procgen
