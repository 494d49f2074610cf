// RecoveringStream on a simulated network and clock, over the server's own PoolRun: a seed decides
// where connections break, what was executed by then, and how time passes. Nothing sleeps.

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "gtest/gtest.h"
#include "procgen_client/run/recovering_stream.h"
#include "server/pool/pool_supervisor.h"
#include "server/rpc/run/pool_run.h"
#include "tests/status_matchers.h"

namespace procgen_client {
namespace {

namespace v1 = procgen::v1;
using procgen::PoolRun;
using procgen::PoolSupervisor;

constexpr int32_t kEnvCount = 6;
constexpr int kRequestCount = 60;
constexpr int kScheduleCount = 400;

using Random = std::mt19937;

int Below(Random& random, int limit) {
  return static_cast<int>(random() % static_cast<unsigned>(limit));
}

std::string TextOf(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  EXPECT_TRUE(buffer.Dump(&slices).ok());
  std::string text;
  for (const grpc::Slice& slice : slices) {
    text.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return text;
}

// Servers that run pools, and a clock.
struct World {
  explicit World(uint32_t seed, bool has_faults) : random(seed), has_faults(has_faults) {}

  RunClock Clock() {
    return {.now = [this] { return now; },
            .sleep = [this](absl::Duration duration) { now += duration; }};
  }

  Random random;
  const bool has_faults;
  absl::Time now = absl::FromUnixSeconds(1000);
  procgen::Metrics metrics{"test"};
  PoolSupervisor supervisor{procgen::Limits(), 1, &metrics};
};

// A call whose requests and responses travel in pieces of random length, until it breaks.
class SimulatedStream final : public RunStream {
 public:
  explicit SimulatedStream(World* world)
      : world_(world),
        run_(std::make_shared<PoolRun>(&world->supervisor, "", [](const absl::Status&) {})),
        events_left_(world->has_faults ? Below(world->random, 3) == 0 ? Below(world->random, 20)
                                                                      : Below(world->random, 400)
                                       : INT32_MAX) {}
  ~SimulatedStream() override { run_->Close(); }

  void Write(const v1::RunPoolRequest& request) override {
    EXPECT_FALSE(writing_.has_value());
    writing_ = request;
  }
  void HalfClose() override { events_left_ = 0; }

  Event Next(absl::Duration timeout) override {
    if (!status_.ok()) {
      return Event::kEnd;
    }
    while (true) {
      if (events_left_-- <= 0) {
        return End(absl::UnavailableError("the connection broke"), /*is_lost=*/true);
      }
      world_->now += absl::Microseconds(Below(world_->random, 2000));
      switch (Below(world_->random, 4)) {
        case 0:
          if (writing_.has_value()) {
            requests_.push_back(*std::exchange(writing_, std::nullopt));
            return Event::kWritten;
          }
          break;
        case 1:
          if (!requests_.empty() && !rejected_.has_value()) {
            Execute();
          }
          break;
        case 2:
          if (!responses_.empty()) {
            response_ = responses_.front();
            responses_.pop_front();
            return Event::kResponse;
          }
          if (rejected_.has_value()) {
            return End(*rejected_, /*is_lost=*/false);
          }
          break;
        default:
          if (timeout <= absl::ZeroDuration() || Below(world_->random, 3) == 0) {
            world_->now += std::min(timeout, absl::Milliseconds(5));
            return Event::kNone;
          }
      }
    }
  }

  grpc::ByteBuffer& response() override { return response_; }
  const absl::Status& status() const override { return status_; }
  bool is_lost() const override { return is_lost_; }
  void Cancel() override { events_left_ = 0; }

 private:
  Event End(absl::Status status, bool is_lost) {
    status_ = std::move(status);
    is_lost_ = is_lost;
    return Event::kEnd;
  }

  void Execute() {
    const v1::RunPoolRequest request = std::move(requests_.front());
    requests_.pop_front();
    absl::Notification done;
    run_->Execute(request, procgen::SteadyNow(), [&](absl::StatusOr<grpc::ByteBuffer> response) {
      if (response.ok()) {
        responses_.push_back(*std::move(response));
      } else {
        rejected_ = response.status();
      }
      done.Notify();
    });
    done.WaitForNotification();
  }

  World* const world_;
  const std::shared_ptr<PoolRun> run_;
  int events_left_;
  std::optional<v1::RunPoolRequest> writing_;
  std::deque<v1::RunPoolRequest> requests_;  // at the server
  std::deque<grpc::ByteBuffer> responses_;   // on their way
  std::optional<absl::Status> rejected_;
  grpc::ByteBuffer response_;
  absl::Status status_;
  bool is_lost_ = false;
};

v1::StartPool StartOf(uint32_t seed) {
  Random random(seed);
  v1::StartPool start;
  v1::PoolSpec* spec = start.mutable_spec();
  spec->add_games("coinrun");
  spec->add_games("miner");
  spec->set_env_count(kEnvCount);
  spec->mutable_options()->set_rand_seed(seed);
  spec->mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
  spec->mutable_options()->set_use_sequential_levels(Below(random, 2) == 0);
  spec->mutable_observation_format()->set_size_px(16);
  spec->set_autoreset_mode(Below(random, 2) == 0 ? v1::AUTORESET_MODE_SAME_STEP
                                                 : v1::AUTORESET_MODE_NEXT_STEP);
  if (Below(random, 3) == 0) {
    spec->mutable_level_sampler()->add_level_seeds(7);
    spec->mutable_level_sampler()->add_level_seeds(8);
  }
  return start;
}

// A request of any kind; one in forty is invalid.
v1::RunPoolRequest RequestOf(Random& random, const std::vector<v1::State>& saved) {
  v1::RunPoolRequest request;
  const int kind = Below(random, 40);
  if (kind == 0) {
    request.mutable_save_states();
  } else if (kind == 1 && !saved.empty()) {
    *request.mutable_restore_states()->add_states() =
        saved[static_cast<size_t>(Below(random, static_cast<int>(saved.size())))];
  } else if (kind == 2) {
    v1::ClonePair* pair = request.mutable_clone_states()->add_pairs();
    pair->set_source_environment(2 * Below(random, kEnvCount / 2));
    pair->set_target_environment(2 * Below(random, kEnvCount / 2));
  } else if (kind == 3) {
    request.mutable_level_sampler()->add_level_seeds(Below(random, 100));
    request.mutable_level_sampler()->add_level_seeds(Below(random, 100));
  } else if (kind == 4) {
    request.mutable_observe()->mutable_slice()->set_env_count(kEnvCount);
  } else if (kind == 5) {
    v1::ResetSlice* reset = request.mutable_reset();
    reset->mutable_slice()->set_env_count(kEnvCount);
    reset->add_resets()->set_environment(Below(random, kEnvCount));
    if (Below(random, 2) == 0) {
      reset->mutable_resets(0)->set_level_seed(Below(random, 1000));
    }
  } else {
    v1::Step* step = request.mutable_step();
    const int first = Below(random, 3) == 0 ? kEnvCount / 2 : 0;
    const int count = kEnvCount / 2 + (first == 0 && Below(random, 2) == 0 ? kEnvCount / 2 : 0);
    step->mutable_slice()->set_first_env(first);
    step->mutable_slice()->set_env_count(count);
    for (int i = 0; i < count; ++i) {
      step->add_actions(Below(random, 60) == 0 ? -1 : Below(random, 15));
    }
    if (kind == 6) {
      step->set_actions(0, 15);  // invalid
    }
    if (kind < 12) {
      v1::NextLevel* next = step->add_next_levels();
      next->set_environment(first);
      next->set_level_seed(Below(random, 1000));
    }
    step->set_observation(kind % 2 == 0 ? v1::OBSERVATION_FRAME : v1::OBSERVATION_NONE);
  }
  return request;
}

struct Trace {
  std::vector<std::string> results;  // responses, or errors
  int64_t call_count = 0;
  int64_t checkpoint_count = 0;
};

// Runs the script of a seed, with up to four requests sent ahead.
Trace TraceOf(uint32_t seed, bool has_faults) {
  World world(seed + 1, has_faults);
  RecoveringStream stream(
      StartOf(seed),
      {.reconnect_timeout = absl::Hours(1), .checkpoint_interval = absl::Milliseconds(30)},
      [&world](int /*attempt*/) { return std::make_unique<SimulatedStream>(&world); },
      world.Clock());
  Trace trace;
  // The first call is not repeated if it breaks before the pool exists.
  if (!stream.Start().ok()) {
    return trace;
  }
  Random script(seed);
  std::vector<v1::State> saved;
  std::deque<bool> saves;  // of the unanswered requests
  int sent = 0;
  while (sent < kRequestCount || !saves.empty()) {
    while (sent < kRequestCount && saves.size() < 4 && (saves.empty() || !saves.back())) {
      v1::RunPoolRequest request = RequestOf(script, saved);
      saves.push_back(request.has_save_states());
      stream.Send(std::move(request));
      ++sent;
    }
    std::optional<absl::StatusOr<grpc::ByteBuffer>> response =
        stream.Receive(absl::Milliseconds(Below(world.random, 20)));
    if (!response.has_value()) {
      continue;
    }
    if (!stream.ended().ok()) {
      trace.results.push_back(absl::StrCat("ended: ", stream.ended().ToString()));
      return trace;
    }
    if (response->ok()) {
      trace.results.push_back(TextOf(**response));
    } else {
      trace.results.push_back(std::string(response->status().message()));
    }
    if (saves.front()) {
      v1::RunPoolResponse states;
      EXPECT_TRUE(states.ParseFromString(trace.results.back()));
      saved.assign(states.states().states().begin(), states.states().states().end());
    }
    saves.pop_front();
  }
  trace.call_count = stream.call_count();
  trace.checkpoint_count = stream.checkpoint_count();
  return trace;
}

TEST(RecoverySimulationTest, TracesOfBrokenConnectionsEqualTheUndisturbedOne) {
  int64_t call_count = 0;
  int64_t checkpoint_count = 0;
  for (uint32_t seed = 1; seed <= kScheduleCount; ++seed) {
    const Trace expected = TraceOf(seed, /*has_faults=*/false);
    ASSERT_EQ(expected.results.size(), static_cast<size_t>(kRequestCount));
    ASSERT_EQ(expected.call_count > 0, true);
    const Trace actual = TraceOf(seed, /*has_faults=*/true);
    if (actual.results.empty()) {
      continue;  // it broke before the pool existed
    }
    call_count += actual.call_count;
    checkpoint_count += actual.checkpoint_count;
    ASSERT_EQ(actual.results.size(), expected.results.size())
        << "seed " << seed << ": " << actual.results.back();
    for (size_t i = 0; i < expected.results.size(); ++i) {
      // The name of the pool, its number, is in messages.
      ASSERT_EQ(actual.results[i] == expected.results[i], true)
          << "seed " << seed << ", request " << i;
    }
  }
  EXPECT_GT(call_count, 5 * kScheduleCount);
  EXPECT_GT(checkpoint_count, kScheduleCount);
}

}  // namespace
}  // namespace procgen_client
