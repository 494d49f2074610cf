#include "tests/server/encoding/encoded_play.h"

#include <cstddef>

#include "absl/types/span.h"

namespace procgen {
namespace {

// One in this many steps ends an environment's episode.
constexpr int32_t kStepsBetweenResets = 40;

std::unique_ptr<Pool> PoolOf(const EncodedPlayOptions& options) {
  PoolOptions pool;
  pool.games = {options.game};
  pool.env_count = options.env_count;
  pool.environment.distribution_mode = options.mode;
  pool.environment.rand_seed = 11;
  pool.observation_format = options.format;
  return Pool::Create(pool, std::make_shared<WorkerPool>(options.worker_count - 1)).value();
}

}  // namespace

EncodedPlay::EncodedPlay(const EncodedPlayOptions& options)
    : options_(options),
      pool_(PoolOf(options)),
      encoder_(
          ObservationCoding(options.format, Encoding::kDeltaZstd).MakeEncoder(options.env_count)),
      random_(5),
      observations_(static_cast<size_t>(options.env_count) * options.format.bytes()) {}

EncodedAnswer EncodedPlay::Next() {
  std::vector<int32_t> actions;
  std::vector<Reset> resets;
  for (int32_t environment = 0; environment < options_.env_count; ++environment) {
    actions.push_back(random_.Int(kActionCount));
    if (random_.Int(kStepsBetweenResets) == 0) {
      resets.push_back({.environment = environment, .level_seed = {}, .rand_seed = {}});
    }
  }
  Batch batch;
  batch.observations = absl::MakeSpan(observations_);
  pool_->Step({.count = options_.env_count, .actions = actions, .resets = resets}, batch)
      .IgnoreError();
  EncodedAnswer answer;
  answer.first = random_.Int(options_.env_count);
  answer.count = 1 + random_.Int(options_.env_count - answer.first);
  const size_t bytes = options_.format.bytes();
  const auto begin = observations_.begin() + static_cast<std::ptrdiff_t>(answer.first * bytes);
  answer.observations.assign(begin, begin + static_cast<std::ptrdiff_t>(answer.count * bytes));
  answer.encoded = encoder_->Encode(answer.first, answer.count, answer.observations);
  return answer;
}

procgen::v1::Pool EncodedPlay::pool() const {
  procgen::v1::Pool pool;
  procgen::v1::PoolSpec& spec = *pool.mutable_spec();
  spec.add_games(options_.game);
  spec.set_env_count(options_.env_count);
  spec.set_encoding(procgen::v1::ENCODING_DELTA_ZSTD);
  procgen::v1::ObservationFormat& format = *spec.mutable_observation_format();
  format.set_color(options_.format.frame.color == Color::kRgb ? procgen::v1::COLOR_RGB
                                                              : procgen::v1::COLOR_GRAYSCALE);
  format.set_layout(options_.format.frame.layout == Layout::kHwc ? procgen::v1::LAYOUT_HWC
                                                                 : procgen::v1::LAYOUT_CHW);
  format.set_size_px(options_.format.frame.size_px);
  format.set_frame_stack(options_.format.frame_stack);
  return pool;
}

}  // namespace procgen
