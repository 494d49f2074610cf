#include "procgen_client/batch.h"

namespace procgen_client {

void Batch::Begin() { first_environment_ = value().first_environment(); }

void Batch::Append(const procgen::v1::Batch& part) {
  procgen::v1::Batch* whole = response_.mutable_batch();
  whole->set_environment_count(whole->environment_count() + part.environment_count());
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

}  // namespace procgen_client
