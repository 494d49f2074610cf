#include "server/dm_env_rpc/joined_world.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/concurrency/deadline_timer.h"
#include "server/session/pool/batch_sink.h"

namespace procgen {

bool Interruption::IsOpen() const {
  absl::MutexLock lock(&mutex_);
  return done_ != nullptr;
}

void Interruption::Settle(End end) {
  Done done;
  {
    absl::MutexLock lock(&mutex_);
    std::swap(done, done_);
  }
  if (done != nullptr) {
    done(end);
  }
}

void JoinedWorld::Join(std::shared_ptr<PoolSession> pool, JoinedWorlds* worlds, OnDrain on_drain,
                       JoinDone done) {
  PoolSession* const session = pool.get();
  if (session->shared_batch_slots() != nullptr) {
    done(absl::FailedPreconditionError(absl::StrCat("pool ", session->name(),
                                                    " shares memory with its learners, allowed: a "
                                                    "pool with TRANSPORT_STREAM")));
    return;
  }
  const std::shared_ptr<JoinedWorld> world(
      new JoinedWorld(std::move(pool), worlds, std::move(on_drain)));
  AttachOptions options;
  options.when_attached = "send LeaveWorld there or end that stream, or create another world";
  session->Attach(
      options,
      [world](StreamEnd why, const absl::Status& reason) { world->OnStreamEnd(why, reason); },
      [world, done = std::move(done)](const absl::Status& attached) mutable {
        if (!attached.ok()) {
          done(attached);
          return;
        }
        world->worlds_->Add(world->identity_, world);
        if (!world->status().ok()) {
          world->worlds_->Remove(world->identity_, world.get());
        }
        done(world);
      });
}

JoinedWorld::JoinedWorld(std::shared_ptr<PoolSession> pool, JoinedWorlds* worlds, OnDrain on_drain)
    : identity_(pool.get()),
      worlds_(worlds),
      on_drain_(std::move(on_drain)),
      pool_(std::move(pool)) {}

absl::Status JoinedWorld::status() const {
  absl::MutexLock lock(&mutex_);
  return lost_;
}

void JoinedWorld::OnStreamEnd(StreamEnd why, const absl::Status& reason) {
  std::shared_ptr<PoolSession> pool;
  {
    absl::MutexLock lock(&mutex_);
    lost_ = reason;
    if (!in_use_) {
      pool = std::move(pool_);
    }
  }
  Detach(pool);
  if (why == StreamEnd::kDrain) {
    on_drain_(reason);
  }
}

void JoinedWorld::Leave() {
  std::shared_ptr<PoolSession> pool;
  {
    absl::MutexLock lock(&mutex_);
    pool = std::move(pool_);
  }
  Detach(pool);
}

void JoinedWorld::Detach(const std::shared_ptr<PoolSession>& pool) {
  if (pool == nullptr) {
    return;
  }
  worlds_->Remove(identity_, this);
  pool->Detach();
  // After Detach, so that the streams that wait here can attach.
  for (const std::shared_ptr<Interruption>& interruption : TakeInterruptions()) {
    interruption->Settle(Interruption::End::kLeft);
  }
}

std::shared_ptr<PoolSession> JoinedWorld::BeginUse() {
  absl::MutexLock lock(&mutex_);
  in_use_ = pool_ != nullptr;
  return pool_;
}

void JoinedWorld::EndUse() {
  std::shared_ptr<PoolSession> pool;
  {
    absl::MutexLock lock(&mutex_);
    in_use_ = false;
    if (!lost_.ok()) {
      pool = std::move(pool_);
    }
  }
  Detach(pool);
}

void JoinedWorld::InTurn(Work work, Done done) {
  std::shared_ptr<PoolSession> pool = BeginUse();
  if (pool == nullptr) {
    done(status());
    return;
  }
  PoolSession* const session = pool.get();
  session->TakeTurn([self = shared_from_this(), pool = std::move(pool), work = std::move(work),
                     done = std::move(done)](const absl::Status& turn) mutable {
    if (!turn.ok()) {
      self->EndUse();
      done(turn);
      return;
    }
    PoolSession* const session = pool.get();
    work(session, [self = std::move(self), pool = std::move(pool),
                   done = std::move(done)](absl::Status status) mutable {
      pool->EndTurn();
      self->EndUse();
      done(std::move(status));
    });
  });
}

void JoinedWorld::Run(const Request& request, const Batch& batch, Done done) {
  std::shared_ptr<PoolSession> pool = BeginUse();
  if (pool == nullptr) {
    done(status());
    return;
  }
  request_ = request;
  request_.arrival_time = SteadyNow();
  request_.sequence_number = pool->next_sequence_number();
  PoolSession* const session = pool.get();
  session->Execute(&request_, std::make_shared<BatchSink>(
                                  batch, [self = shared_from_this(), pool = std::move(pool),
                                          done = std::move(done)](absl::Status status) mutable {
                                    self->EndUse();
                                    done(std::move(status));
                                  }));
}

void JoinedWorld::Interrupt(std::shared_ptr<Interruption> interruption) {
  {
    absl::MutexLock lock(&mutex_);
    if (pool_ != nullptr) {
      interruptions_.push_back(std::move(interruption));
      return;
    }
  }
  interruption->Settle(Interruption::End::kLeft);
}

std::vector<std::shared_ptr<Interruption>> JoinedWorld::TakeInterruptions() {
  absl::MutexLock lock(&mutex_);
  std::vector<std::shared_ptr<Interruption>> taken;
  taken.swap(interruptions_);
  // Cancelled interruptions have no effect.
  taken.erase(std::remove_if(taken.begin(), taken.end(),
                             [](const auto& interruption) { return !interruption->IsOpen(); }),
              taken.end());
  return taken;
}

std::shared_ptr<JoinedWorld> JoinedWorlds::Find(const PoolSession& pool) const {
  absl::MutexLock lock(&mutex_);
  const auto found = joined_.find(&pool);
  return found == joined_.end() ? nullptr : found->second.lock();
}

void JoinedWorlds::Add(const PoolSession* pool, std::weak_ptr<JoinedWorld> joined) {
  absl::MutexLock lock(&mutex_);
  joined_[pool] = std::move(joined);
}

void JoinedWorlds::Remove(const PoolSession* pool, const JoinedWorld* joined) {
  absl::MutexLock lock(&mutex_);
  const auto found = joined_.find(pool);
  // Another stream may have joined in the meantime.
  if (found != joined_.end() && found->second.lock().get() == joined) {
    joined_.erase(found);
  }
}

}  // namespace procgen
