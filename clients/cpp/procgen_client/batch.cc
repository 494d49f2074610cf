#include "procgen_client/batch.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace procgen_client {

void Batch::Begin() {
  first_env_ = value().first_env();
  parts_.assign(1, {first_env_, env_count(), value().observations().size()});
}

void Batch::Append(const procgen::v1::Batch& part) {
  procgen::v1::Batch* whole = response_.mutable_batch();
  parts_.push_back({part.first_env(), part.env_count(), part.observations().size()});
  whole->set_env_count(whole->env_count() + part.env_count());
  whole->mutable_rewards()->MergeFrom(part.rewards());
  whole->mutable_first()->MergeFrom(part.first());
  whole->mutable_terminated()->MergeFrom(part.terminated());
  whole->mutable_truncated()->MergeFrom(part.truncated());
  whole->mutable_level_seeds()->MergeFrom(part.level_seeds());
  whole->mutable_prev_level_seeds()->MergeFrom(part.prev_level_seeds());
  whole->mutable_prev_level_complete()->MergeFrom(part.prev_level_complete());
  whole->mutable_episode_returns()->MergeFrom(part.episode_returns());
  whole->mutable_episode_lengths()->MergeFrom(part.episode_lengths());
  whole->mutable_fingerprints()->MergeFrom(part.fingerprints());
  whole->mutable_final_observations()->append(part.final_observations());
  whole->mutable_observations()->append(part.observations());
}

absl::Status Batch::Decode(ObservationDecoder* decoder) {
  absl::string_view encoded = value().observations();
  if (decoder == nullptr || encoded.empty()) {
    decoded_.clear();
    return absl::OkStatus();
  }
  int32_t rows = 0;
  for (const Part& part : parts_) {
    rows += part.env_count;
  }
  // Not cleared before, which would zero all of it.
  decoded_.resize(static_cast<size_t>(rows) * decoder->observation_bytes());
  absl::Span<uint8_t> left = absl::MakeSpan(decoded_);
  for (const Part& part : parts_) {
    const size_t bytes = static_cast<size_t>(part.env_count) * decoder->observation_bytes();
    const absl::Status status =
        decoder->Decode(part.first_env, part.env_count, encoded.substr(0, part.observation_bytes),
                        left.first(bytes));
    if (!status.ok()) {
      return absl::DataLossError(absl::StrCat("the server's answer to request ", sequence_number(),
                                              ": ", status.message()));
    }
    encoded.remove_prefix(part.observation_bytes);
    left.remove_prefix(bytes);
  }
  return absl::OkStatus();
}

}  // namespace procgen_client
