#include "server/rpc/attach.h"

#include <algorithm>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "server/rpc/convert_pool.h"
#include "server/rpc/response_limit.h"
#include "server/session/event_log.h"

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

}  // namespace

absl::StatusOr<StreamTerms> ReadAttach(const v1::StepPoolRequest& request, const Limits& limits) {
  if (!request.has_attach()) {
    return absl::InvalidArgumentError(
        "the first request of a stream has no attach; name the pool there");
  }
  if (request.sequence_number() != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("sequence_number is ", request.sequence_number(), " with attach, allowed: 0"));
  }
  const v1::Attach& attach = request.attach();
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
  StreamTerms terms;
  terms.options.requests_in_flight_max = *in_flight;
  terms.options.resumable = attach.resumable();
  terms.options.take_over = attach.take_over();
  terms.response_bytes_max = *response_bytes_max;
  return terms;
}

void AttachStream(const Sessions* sessions, absl::string_view owner,
                  const v1::StepPoolRequest& request, PoolSession::EndStream end_stream,
                  absl::AnyInvocable<void(absl::StatusOr<Attachment>)> done) {
  const absl::StatusOr<StreamTerms> terms = ReadAttach(request, sessions->limits());
  if (!terms.ok()) {
    done(terms.status());
    return;
  }
  const absl::StatusOr<std::shared_ptr<PoolSession>> pool =
      sessions->FindForStream(owner, request.attach().pool());
  if (!pool.ok()) {
    done(pool.status());
    return;
  }
  (*pool)->Attach(
      terms->options, std::move(end_stream),
      [sessions, attachment = Attachment{*pool, *terms},
       done = std::move(done)](absl::Status status) mutable {
        if (status.ok() && sessions->draining()) {
          attachment.pool->Detach();  // all streams may have been told before this one
          status = Sessions::Draining();
        }
        if (!status.ok()) {
          done(std::move(status));
          return;
        }
        sessions->metrics().AddStream(attachment.terms.options.resumable &&
                                      attachment.pool->next_sequence_number() > 1);
        LogEvent(LogLevel::kInfo, "stream_attached",
                 {{"pool", attachment.pool->name()},
                  {"owner", attachment.pool->owner()},
                  {"next_sequence_number", absl::StrCat(attachment.pool->next_sequence_number())}});
        done(std::move(attachment));
      });
}

void FillAttached(const PoolSession& pool, const StreamTerms& terms,
                  v1::StepPoolResponse* response) {
  response->set_sequence_number(0);
  v1::Attached* attached = response->mutable_attached();
  *attached->mutable_pool() = PoolMessageOf(pool);
  attached->set_next_sequence_number(pool.next_sequence_number());
  attached->set_oldest_kept_sequence_number(pool.oldest_kept_sequence_number());
  attached->set_response_bytes_max(terms.response_bytes_max);
  attached->set_requests_in_flight_max(terms.options.requests_in_flight_max);
}

}  // namespace procgen
