#include "server/session/pool/pool_session.h"

#include <algorithm>
#include <deque>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/concurrency/deadline_timer.h"
#include "server/session/pool/batch_sink.h"

namespace procgen {
namespace {

// Multiple of the last capture's duration during which no capture runs, up to a maximum.
constexpr int kPausePerCapture = 99;
constexpr absl::Duration kPauseMax = absl::Seconds(1);

absl::Status NoEpisodes() {
  return absl::UnimplementedError(
      "this server remembers no episodes, limit episode_history_bytes_max is 0");
}

}  // namespace

PoolSession::PoolSession(std::string owner, std::string name, std::unique_ptr<PoolBackend> backend,
                         absl::Duration lease_duration, const PoolContext& context,
                         Encoding encoding, const SharedMemoryDir* shared_memory_dir)
    : owner_(std::move(owner)),
      name_(std::move(name)),
      backend_(std::move(backend)),
      coding_(backend_->options().observation_format, encoding),
      context_(context),
      create_time_(context.lease_timer->Now()),
      shared_batch_slots_(shared_memory_dir == nullptr
                              ? nullptr
                              : std::make_unique<SharedBatchSlots>(
                                    shared_memory_dir, backend_->env_count(), observation_bytes())),
      turns_(name_),
      resume_buffer_(name_, AnswerBytesMax(), context.resume_buffer_bytes,
                     shared_batch_slots_ != nullptr),
      observers_(backend_->options(), context),
      executor_({.pool_name = name_,
                 .backend = backend_.get(),
                 .turns = &turns_,
                 .resume_buffer = &resume_buffer_,
                 .observers = &observers_,
                 .metrics = context.metrics}),
      stream_({.owner = owner_,
               .pool_name = name_,
               .quotas = context.quotas,
               .lease_timer = context.lease_timer,
               .resume_buffer = &resume_buffer_,
               .next_sequence_number = &executor_.next_sequence_number()},
              lease_duration) {}

PoolSession::~PoolSession() {
  if (shared_batch_slots_ != nullptr) {
    context_.shared_memory_bytes->Change(shared_batch_slots_->size_bytes(), 0);
  }
}

int64_t PoolSession::AnswerBytesMax() const {
  // An observation, a final observation (not encoded), and the other fields of a response of one
  // environment.
  constexpr int64_t kRowBytesMax = 512;
  if (shared_batch_slots_ != nullptr) {
    return kRowBytesMax;  // a batch number
  }
  return env_count() * (coding_.sent_bytes_max() + coding_.drawn_bytes() + kRowBytesMax);
}

void PoolSession::ResumeAt(int64_t next_sequence_number) {
  if (next_sequence_number > 1) {
    observers_.ForgetEpisodes(env_count());
  }
  executor_.ResumeAt(next_sequence_number);
}

void PoolSession::Attach(const AttachOptions& options, EndStream end_stream, Done done) {
  stream_.Attach(
      options,
      [this, end_stream = std::move(end_stream)](StreamEnd why,
                                                 const absl::Status& reason) mutable {
        pause_.PassStream();  // first, because the stream may detach at once
        end_stream(why, reason);
      },
      std::move(done));
}

void PoolSession::ShareMemory(const AttachOptions& options, Done done) {
  if (shared_batch_slots_ == nullptr) {
    done(absl::OkStatus());
    return;
  }
  const int32_t held_max =
      options.held_batches_max == 0 ? kHeldBatchesDefault : options.held_batches_max;
  context_.executor->Run(owner_, [this, batch_count = options.requests_in_flight_max + held_max,
                                  done = std::move(done)]() mutable {
    absl::Status status = GrowSharedBatchSlots(batch_count);
    done(std::move(status));
  });
}

absl::Status PoolSession::GrowSharedBatchSlots(int32_t batch_count) {
  const int64_t before = shared_batch_slots_->size_bytes();
  const int64_t after = std::max(before, batch_count * shared_batch_slots_->layout().batch_bytes());
  ByteBudget* budget = context_.shared_memory_bytes;
  if (!budget->Change(before, after)) {
    return absl::ResourceExhaustedError(
        absl::StrCat("pool ", name_, " shares ", batch_count, " batches of ",
                     shared_batch_slots_->layout().batch_bytes(), " bytes, and other pools ",
                     budget->reserved_bytes() - before, " bytes, limit shared_memory_bytes_max is ",
                     budget->bytes_max()));
  }
  if (absl::Status status = shared_batch_slots_->Grow(batch_count); !status.ok()) {
    budget->Change(after, before);
    return status;
  }
  resume_buffer_.GrowBatches(batch_count);
  return absl::OkStatus();
}

void PoolSession::Close(const absl::Status& reason) {
  stream_.Close(reason);
  backend_->Discard();
  NotifyClosed(reason);
}

void PoolSession::Fail(const absl::Status& reason) {
  if (stream_.CloseIfOpen(reason)) {
    NotifyClosed(reason);
  }
}

bool PoolSession::CloseIfExpired(absl::Time now) {
  const absl::Status reason =
      absl::NotFoundError(absl::StrCat("there is no pool ", name_, " any more: its lease ran out"));
  if (!stream_.CloseIfExpired(now, reason)) {
    return false;
  }
  backend_->Discard();
  NotifyClosed(reason);
  return true;
}

void PoolSession::NotifyClosed(const absl::Status& reason) {
  std::deque<TurnQueue::Begin> waiting = turns_.Close(reason);
  stream_.EndAll(reason);
  EndObservers(reason);
  for (TurnQueue::Begin& begin : waiting) {
    begin(reason);
  }
}

void PoolSession::Execute(Request* request, std::shared_ptr<ResponseSink> sink) {
  pause_.Pass([this, request, sink = std::move(sink)]() mutable {
    executor_.Execute(request, std::move(sink));
  });
}

void PoolSession::SaveStates(absl::Span<const int32_t> environments, TakeState take, Done done) {
  backend_->SaveStates(environments, std::move(take), std::move(done));
}

void PoolSession::RestoreStates(std::vector<StateToRestore> states, Done done) {
  observers_.AddChange();
  observers_.OnInvalidated();
  std::vector<StateToRestore> restored = states;
  backend_->RestoreStates(std::move(states), [this, restored = std::move(restored),
                                              done = std::move(done)](absl::Status status) mutable {
    if (status.ok()) {
      observers_.OnRestore(restored);
    }
    done(std::move(status));
  });
}

void PoolSession::CloneStates(std::vector<StateToClone> pairs, Done done) {
  observers_.AddChange();
  observers_.OnInvalidated();
  std::vector<StateToClone> cloned = pairs;
  backend_->CloneStates(std::move(pairs), [this, cloned = std::move(cloned),
                                           done = std::move(done)](absl::Status status) mutable {
    if (status.ok()) {
      observers_.OnClone(cloned);
    }
    done(std::move(status));
  });
}

absl::StatusOr<EpisodeRecording> PoolSession::FindEpisode(int32_t environment,
                                                          uint64_t fingerprint) const {
  const EpisodeLog* const episodes = observers_.episodes();
  if (episodes == nullptr) {
    return NoEpisodes();
  }
  if (absl::StatusOr<EpisodeRecording> last = episodes->Read(environment, /*under_way=*/false);
      last.ok() && last->summary.fingerprint == fingerprint) {
    return last;
  }
  std::optional<EpisodeRecording> found = recent_episodes().Find(environment, fingerprint);
  if (!found.has_value()) {
    return absl::NotFoundError(
        absl::StrCat("environment ", environment, " of ", name(), " has no recording of episode ",
                     absl::Hex(fingerprint, absl::kZeroPad16), ": a pool keeps those of its last ",
                     RecentEpisodes::kListedMax, " episodes, or fewer if they are long"));
  }
  return *std::move(found);
}

void PoolSession::GetEpisode(int32_t environment, bool under_way, EpisodeDone done) {
  EpisodeLog* const episodes = observers_.episodes();
  if (episodes == nullptr) {
    done(NoEpisodes());
    return;
  }
  if (!under_way || episodes->KnowsLevel(environment)) {
    done(episodes->Read(environment, under_way));
    return;
  }
  // The environment has no steps yet, so an observation contains its level seed.
  struct Observed {
    Request request;
    int32_t level_seed = 0;
  };
  auto observed = std::make_shared<Observed>();
  observed->request.first = environment;
  observed->request.count = 1;
  Batch batch;
  batch.level_seeds = absl::MakeSpan(&observed->level_seed, 1);
  Request* const request = &observed->request;
  ExecuteInTurn(request, std::make_shared<BatchSink>(
                             batch, [episodes, environment, observed = std::move(observed),
                                     done = std::move(done)](const absl::Status& status) mutable {
                               if (!status.ok()) {
                                 done(status);
                                 return;
                               }
                               episodes->SetLevel(environment, observed->level_seed);
                               done(episodes->Read(environment, /*under_way=*/true));
                             }));
}

void PoolSession::CaptureScenes(const std::vector<int32_t>& environments, View view,
                                int32_t size_px, PoolBackend::CaptureDone done) {
  backend_->CaptureScenes(environments, view, size_px, std::move(done));
}

void PoolSession::NoteCapture(absl::Time begin_time) {
  const absl::Time now = SteadyNow();
  next_capture_ns_ =
      absl::ToUnixNanos(now + std::min((now - begin_time) * kPausePerCapture, kPauseMax));
}

}  // namespace procgen
