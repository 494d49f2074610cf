#include "server/fleet/log/shard_request.h"

#include <algorithm>

namespace procgen {
namespace {

v1::Observation ObservationOf(const Batch& pictures) {
  return pictures.observations.empty() ? v1::OBSERVATION_NONE : v1::OBSERVATION_FRAME;
}

template <typename Message>
void SetSlice(Part part, Message* message) {
  message->mutable_slice()->set_first_env(part.first);
  message->mutable_slice()->set_env_count(part.count);
}

template <typename Message>
void AddResets(absl::Span<const Reset> resets, Message* message) {
  for (const Reset& reset : resets) {
    v1::Reset* added = message->add_resets();
    added->set_environment(reset.environment);
    if (reset.level_seed.has_value()) {
      added->set_level_seed(*reset.level_seed);
    }
    if (reset.rand_seed.has_value()) {
      added->set_rand_seed(*reset.rand_seed);
    }
  }
}

void FillStep(const Request& request, const Batch& pictures, v1::Step* step) {
  SetSlice({request.first, request.count}, step);
  step->mutable_actions()->Add(request.actions.begin(), request.actions.end());
  step->set_repeat_count(request.repeat);
  step->set_observation(ObservationOf(pictures));
  step->set_with_final_observations(!pictures.final_observations.empty());
  for (const NextLevel& next : request.next_levels) {
    v1::NextLevel* added = step->add_next_levels();
    added->set_environment(next.environment);
    added->set_level_seed(next.level_seed);
  }
  AddResets(request.resets, step);
}

Part SliceOf(const v1::Slice& slice) { return {slice.first_env(), slice.env_count()}; }

// The elements that belong to `part`, renumbered from `offset`.
template <typename Element>
void CutList(const google::protobuf::RepeatedPtrField<Element>& list, Part part, int32_t offset,
             google::protobuf::RepeatedPtrField<Element>* cut) {
  for (const Element& element : list) {
    if (element.environment() >= part.first && element.environment() < part.first + part.count) {
      Element* added = cut->Add();
      *added = element;
      added->set_environment(element.environment() - offset);
    }
  }
}

void CutStep(const v1::Step& step, Part part, int32_t offset, v1::Step* cut) {
  SetSlice({part.first - offset, part.count}, cut);
  const int* actions = step.actions().data() + (part.first - step.slice().first_env());
  cut->mutable_actions()->Add(actions, actions + part.count);
  cut->set_repeat_count(step.repeat_count());
  cut->set_observation(step.observation());
  cut->set_with_final_observations(step.with_final_observations());
  CutList(step.next_levels(), part, offset, cut->mutable_next_levels());
  CutList(step.resets(), part, offset, cut->mutable_resets());
}

}  // namespace

Part Overlap(Part left, Part right) {
  const int32_t first = std::max(left.first, right.first);
  const int32_t end = std::min(left.first + left.count, right.first + right.count);
  return {first, std::max(0, end - first)};
}

v1::StepPoolRequest RequestMessageOf(const Request& request, const Batch& pictures) {
  v1::StepPoolRequest message;
  message.set_sequence_number(request.sequence_number);
  const Part slice = {request.first, request.count};
  switch (request.kind) {
    case Request::Kind::kStep:
      FillStep(request, pictures, message.mutable_step());
      break;
    case Request::Kind::kReset:
      SetSlice(slice, message.mutable_reset());
      AddResets(request.resets, message.mutable_reset());
      message.mutable_reset()->set_observation(ObservationOf(pictures));
      break;
    case Request::Kind::kObserve:
      SetSlice(slice, message.mutable_observe());
      message.mutable_observe()->set_observation(ObservationOf(pictures));
      break;
    case Request::Kind::kSample:
      *message.mutable_level_sampler() = LevelSamplerMessageOf(*request.level_sampler);
      break;
  }
  return message;
}

std::optional<v1::StepPoolRequest> CutRequest(const v1::StepPoolRequest& request, Part range) {
  v1::StepPoolRequest cut;
  if (request.has_level_sampler()) {
    *cut.mutable_level_sampler() = request.level_sampler();
    return cut;
  }
  const Part part = Overlap(SliceOf(request, 0), range);
  if (part.count == 0) {
    return std::nullopt;
  }
  const Part own = {part.first - range.first, part.count};
  if (request.has_step()) {
    CutStep(request.step(), part, range.first, cut.mutable_step());
  } else if (request.has_reset()) {
    CutList(request.reset().resets(), part, range.first, cut.mutable_reset()->mutable_resets());
    SetSlice(own, cut.mutable_reset());
    cut.mutable_reset()->set_observation(request.reset().observation());
  }
  if (request.has_observe() || (cut.has_reset() && cut.reset().resets().empty())) {
    const v1::Observation observation =
        request.has_observe() ? request.observe().observation() : request.reset().observation();
    SetSlice(own, cut.mutable_observe());
    cut.mutable_observe()->set_observation(observation);
  }
  return cut;
}

void DisableObservations(v1::StepPoolRequest* request) {
  if (request->has_step()) {
    request->mutable_step()->set_observation(v1::OBSERVATION_NONE);
    request->mutable_step()->set_with_final_observations(false);
  } else if (request->has_reset()) {
    request->mutable_reset()->set_observation(v1::OBSERVATION_NONE);
  } else if (request->has_observe()) {
    request->mutable_observe()->set_observation(v1::OBSERVATION_NONE);
  }
}

v1::LevelSampler LevelSamplerMessageOf(const LevelSampler& level_sampler) {
  v1::LevelSampler message;
  message.mutable_level_seeds()->Assign(level_sampler.level_seeds().begin(),
                                        level_sampler.level_seeds().end());
  message.mutable_weights()->Assign(level_sampler.weights().begin(), level_sampler.weights().end());
  message.set_rand_seed(level_sampler.rand_seed());
  return message;
}

Part SliceOf(const v1::StepPoolRequest& request, int32_t env_count) {
  if (request.has_step()) {
    return SliceOf(request.step().slice());
  }
  if (request.has_reset()) {
    return SliceOf(request.reset().slice());
  }
  if (request.has_observe()) {
    return SliceOf(request.observe().slice());
  }
  return {0, env_count};
}

}  // namespace procgen
