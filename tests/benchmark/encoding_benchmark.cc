// procgen-benchmark-encoding: size of encoded observations and cost of encoding and decoding, per
// game and mode. README.md in this folder describes the counters.
//
//   --art_dir DIR    folder of art to draw with; default: the built-in art

#include <cmath>
#include <cstdint>
#include <iomanip>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "benchmark/benchmark.h"
#include "envcore/games/game_catalog.h"
#include "procgen_client/observation_decoder.h"
#include "server/encoding/observation_encoder.h"
#include "tests/benchmark/art_flag.h"
#include "tests/benchmark/learners/local_learner.h"
#include "tests/benchmark/measuring/benchmark_run.h"
#include "tests/benchmark/measuring/round_clock.h"

namespace procgen {
namespace {

constexpr double kMinTimeSeconds = 1.5;
// Bytes are counted over a fixed number of steps, independent of the machine's speed.
constexpr int kCountedSteps = 200;
constexpr int32_t kEnvCount = LocalLearner::kEnvCount;

// Results per observation: the columns of the closing table.
struct Figures {
  double bytes = 0;
  double encode_us = 0;
  double decode_us = 0;
  double encode_units = 0;
  double decode_units = 0;
};

// By game. Google Benchmark first tries each case with few iterations; only the last try counts.
using FiguresOfGames = std::map<std::string, Figures>;

// By mode.
std::map<std::string, FiguresOfGames>& AllFigures() {
  static auto& figures = *new std::map<std::string, FiguresOfGames>;
  return figures;
}

// A learner whose observations are encoded and decoded after each step.
class Trip {
 public:
  explicit Trip(LocalLearner learner)
      : learner_(std::move(learner)), decoded_(learner_.observations().size()) {}

  // Steps, encodes and decodes once. Sets `round_ends` if a round of either clock is complete.
  absl::Status Step(bool& round_ends) {
    if (absl::Status status = learner_.Step(); !status.ok()) {
      return status;
    }
    encode_.Start();
    const std::string encoded = encoder_.Encode(0, kEnvCount, learner_.observations());
    round_ends = encode_.Lap();
    decode_.Start();
    absl::Status status = decoder_.Decode(0, kEnvCount, encoded, absl::MakeSpan(decoded_));
    round_ends |= decode_.Lap();
    if (status.ok() && absl::MakeConstSpan(decoded_) != learner_.observations()) {
      return absl::InternalError("decoded observations differ from the encoded ones");
    }
    if (step_count_ < kCountedSteps) {
      bytes_ += static_cast<double>(encoded.size());
      ++step_count_;
    }
    return status;
  }

  // Encodes and decodes the first observations, which are not counted.
  absl::Status Begin() {
    return decoder_.Decode(0, kEnvCount, encoder_.Encode(0, kEnvCount, learner_.observations()),
                           absl::MakeSpan(decoded_));
  }

  void MeasureUnit() {
    encode_.MeasureUnit();
    decode_.MeasureUnit();
  }

  Figures Result() const {
    return {.bytes = bytes_ / step_count_ / kEnvCount,
            .encode_us = absl::ToDoubleMicroseconds(encode_.Best()) / kEnvCount,
            .decode_us = absl::ToDoubleMicroseconds(decode_.Best()) / kEnvCount,
            .encode_units = encode_.BestInUnits() / kEnvCount,
            .decode_units = decode_.BestInUnits() / kEnvCount};
  }

 private:
  LocalLearner learner_;
  ObservationEncoder encoder_{kEnvCount, kObservationBytes};
  procgen_client::ObservationDecoder decoder_{kEnvCount, kObservationBytes};
  std::vector<uint8_t> decoded_;
  RoundClock encode_{TimeKind::kThread};
  RoundClock decode_{TimeKind::kThread};
  double bytes_ = 0;
  int step_count_ = 0;
};

void Report(const Figures& figures, benchmark::State& state) {
  state.counters["bytes"] = figures.bytes;
  state.counters["encode_us"] = figures.encode_us;
  state.counters["decode_us"] = figures.decode_us;
  state.counters["encode_units"] = figures.encode_units;
  state.counters["decode_units"] = figures.decode_units;
}

void RunCase(const LocalCase& local_case, benchmark::State& state) {
  absl::StatusOr<LocalLearner> learner = LocalLearner::Start(local_case);
  if (!learner.ok()) {
    state.SkipWithError(learner.status().ToString().c_str());
    return;
  }
  Trip trip(*std::move(learner));
  absl::Status status = trip.Begin();
  for ([[maybe_unused]] const auto iteration : state) {
    bool round_ends = false;
    if (status.ok()) {
      status = trip.Step(round_ends);
    }
    if (!status.ok()) {
      state.SkipWithError(status.ToString().c_str());
      return;
    }
    if (round_ends) {
      state.PauseTiming();
      trip.MeasureUnit();
      state.ResumeTiming();
    }
  }
  trip.MeasureUnit();
  Report(trip.Result(), state);
  AllFigures()[std::string(DistributionModeName(local_case.mode))][local_case.game] = trip.Result();
}

void RegisterCases() {
  const std::shared_ptr<const SharedArt> art = ArtOfFlag();
  for (const DistributionMode mode : {DistributionMode::kEasy, DistributionMode::kHard}) {
    for (const GameSpec& game : GameCatalog()) {
      const LocalCase local_case = {.game = std::string(game.name), .mode = mode, .art = art};
      benchmark::RegisterBenchmark(
          absl::StrCat("encoding/", game.name, "/", DistributionModeName(mode)).c_str(),
          [local_case](benchmark::State& state) { RunCase(local_case, state); });
    }
  }
}

double GeometricMean(const FiguresOfGames& all, double Figures::*figure) {
  double sum = 0;
  for (const auto& [game, figures] : all) {
    sum += std::log(figures.*figure);
  }
  return std::exp(sum / static_cast<double>(all.size()));
}

void PrintMeans() {
  std::cout << "\ngeometric means of one observation\n"
            << "mode           games     bytes  encode_us  decode_us  encode_units  decode_units\n"
            << std::fixed;
  for (const auto& [group, all] : AllFigures()) {
    std::cout << std::left << std::setw(13) << group << std::right << std::setw(7) << all.size()
              << std::setprecision(1) << std::setw(10) << GeometricMean(all, &Figures::bytes)
              << std::setprecision(3) << std::setw(11) << GeometricMean(all, &Figures::encode_us)
              << std::setw(11) << GeometricMean(all, &Figures::decode_us) << std::setw(14)
              << GeometricMean(all, &Figures::encode_units) << std::setw(14)
              << GeometricMean(all, &Figures::decode_units) << "\n";
  }
}

}  // namespace
}  // namespace procgen

int main(int argc, char** argv) {
  const int status =
      procgen::RunBenchmarks(argc, argv, procgen::kMinTimeSeconds, procgen::RegisterCases);
  if (status == 0) {
    procgen::PrintMeans();
  }
  return status;
}
