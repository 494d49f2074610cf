// procgen-make-request-corpus FOLDER: writes the seed inputs of request_fuzz and run_fuzz to
// FOLDER/request and FOLDER/run: valid requests, and some that are nearly valid.

#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/cluster.pb.h"
#include "procgen/v1/episodes.pb.h"
#include "procgen/v1/pool_service.pb.h"
#include "procgen/v1/render.pb.h"
#include "procgen/v1/run.pb.h"
#include "tests/fuzz/pieces.h"
#include "tests/fuzz/request_methods.h"

namespace procgen {
namespace {

constexpr int kBadUse = 2;

void Write(const std::filesystem::path& path, const std::vector<Piece>& pieces) {
  std::ofstream(path, std::ios::binary) << InputOf(pieces);
}

template <typename Message>
Piece Call(RequestMethod method, const Message& message) {
  return {false, std::string(1, static_cast<char>(method)) + message.SerializeAsString()};
}

void WriteCalls(const std::filesystem::path& folder) {
  v1::GetPoolRequest get;
  get.set_name("pools/a");
  v1::ListPoolsRequest list;
  list.set_page_size(1);
  list.set_page_token("1");
  Write(folder / "pools",
        {Call(kGetPool, get), Call(kListPools, v1::ListPoolsRequest()), Call(kListPools, list)});
  Write(folder / "catalog",
        {Call(kGetCatalog, v1::GetCatalogRequest()), Call(kGetLoad, v1::GetLoadRequest())});
  Write(folder / "cluster",
        {Call(kListNodes, v1::ListNodesRequest()), Call(kWatchNodes, v1::WatchNodesRequest())});
  v1::WatchPoolRequest watch;
  watch.set_pool("pools/a");
  watch.add_environments(1);
  watch.set_size_px(64);
  watch.set_frames_per_second_max(60);
  v1::WatchPoolRequest smooth = watch;
  smooth.set_size_px(32);
  smooth.set_format(v1::FRAME_FORMAT_PNG);
  smooth.set_with_steps(true);
  Write(folder / "watching", {Call(kWatchPool, watch), Call(kWatchPool, smooth)});
  v1::GetEpisodeRequest last;
  last.set_pool("pools/a");
  v1::GetEpisodeRequest current = last;
  current.set_environment(1);
  current.set_selector(v1::EPISODE_SELECTOR_CURRENT);
  v1::GetEpisodeRequest ended = last;
  ended.set_fingerprint(7);
  Write(folder / "episodes",
        {Call(kGetEpisode, last), Call(kGetEpisode, current), Call(kGetEpisode, ended)});
  get.set_name("pools/none");
  Write(folder / "refused", {Call(kGetPool, get), {false, "\x02\x0a\xff\xff"}});
}

const Piece kMark = {true, ""};

Piece Message(const v1::RunPoolRequest& request) { return {false, request.SerializeAsString()}; }

v1::RunPoolRequest Start(const std::string& game, int32_t env_count) {
  v1::RunPoolRequest request;
  v1::PoolSpec& spec = *request.mutable_start()->mutable_spec();
  spec.add_games(game);
  spec.set_env_count(env_count);
  spec.mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
  spec.mutable_options()->set_rand_seed(9);
  return request;
}

v1::RunPoolRequest Step(int32_t first, const std::vector<int32_t>& actions) {
  v1::RunPoolRequest request;
  v1::Step& step = *request.mutable_step();
  step.mutable_slice()->set_first_env(first);
  step.mutable_slice()->set_env_count(static_cast<int32_t>(actions.size()));
  step.mutable_actions()->Add(actions.begin(), actions.end());
  return request;
}

v1::RunPoolRequest Observe(int32_t first, int32_t count) {
  v1::RunPoolRequest request;
  request.mutable_observe()->mutable_slice()->set_first_env(first);
  request.mutable_observe()->mutable_slice()->set_env_count(count);
  return request;
}

v1::RunPoolRequest ResetOf(int32_t environment) {
  v1::RunPoolRequest request;
  request.mutable_reset()->mutable_slice()->set_env_count(2);
  v1::Reset& reset = *request.mutable_reset()->add_resets();
  reset.set_environment(environment);
  reset.set_level_seed(5);
  reset.set_rand_seed(6);
  return request;
}

// A step with all fields.
v1::RunPoolRequest FullStep() {
  v1::RunPoolRequest request = Step(1, {4});
  v1::Step& step = *request.mutable_step();
  step.set_repeat_count(3);
  step.set_observation(v1::OBSERVATION_NONE);
  step.set_with_final_observations(true);
  step.add_next_levels()->set_environment(1);
  step.mutable_next_levels(0)->set_level_seed(77);
  step.add_resets()->set_environment(1);
  v1::Annotation& annotation = *step.add_annotations();
  annotation.set_name("value");
  annotation.add_values(0.5F);
  return request;
}

v1::RunPoolRequest RenderOf(v1::FrameView view, int32_t size_px, v1::FrameFormat format) {
  v1::RunPoolRequest request;
  request.mutable_render()->add_environments(1);
  request.mutable_render()->add_environments(1);
  request.mutable_render()->set_view(view);
  request.mutable_render()->set_size_px(size_px);
  request.mutable_render()->set_format(format);
  return request;
}

void WritePlays(const std::filesystem::path& folder) {
  Write(folder / "learner",
        {Message(Start("maze", 2)), Message(Observe(0, 2)), Message(Step(0, {4, 7})),
         Message(FullStep()), Message(ResetOf(0)), Message(Observe(1, 1))});
  v1::RunPoolRequest formatted = Start("bigfish", 4);
  v1::PoolSpec& spec = *formatted.mutable_start()->mutable_spec();
  spec.add_games("maze");
  spec.set_first_env(2);
  spec.set_total_env_count(8);
  spec.mutable_options()->set_num_levels(5);
  spec.mutable_options()->set_start_level(3);
  spec.set_autoreset_mode(v1::AUTORESET_MODE_NEXT_STEP);
  spec.mutable_observation_format()->set_color(v1::COLOR_GRAYSCALE);
  spec.mutable_observation_format()->set_layout(v1::LAYOUT_CHW);
  spec.mutable_observation_format()->set_size_px(20);
  spec.mutable_observation_format()->set_frame_stack(2);
  Write(folder / "formatted", {Message(formatted), Message(Step(1, {-1, 2})),
                               Message(Step(0, {1, 2, 3, 4})), Message(Observe(3, 1))});
  v1::RunPoolRequest encoded = Start("coinrun", 3);
  encoded.mutable_start()->mutable_spec()->set_encoding(v1::ENCODING_DELTA_ZSTD);
  encoded.mutable_start()->mutable_spec()->set_autoreset_mode(v1::AUTORESET_MODE_DISABLED);
  Write(folder / "encoded", {Message(encoded), Message(Step(0, {1, 4, 4})), Message(Observe(1, 2)),
                             Message(Step(0, {-1, 4, 4})), Message(Step(0, {4, 4, 4}))});
  v1::RunPoolRequest finals = Step(0, {-1, 3});
  finals.mutable_step()->set_with_final_observations(true);
  v1::RunPoolRequest acknowledged = Step(0, {1, 2});
  acknowledged.mutable_step()->set_acknowledge_only(true);
  Write(folder / "acknowledged",
        {Message(Start("maze", 2)), Message(acknowledged), Message(finals), Message(acknowledged)});
  v1::RunPoolRequest sampler;
  sampler.mutable_level_sampler()->add_level_seeds(3);
  v1::RunPoolRequest sampled = Start("maze", 2);
  sampled.mutable_start()->mutable_spec()->mutable_level_sampler()->add_level_seeds(7);
  sampled.mutable_start()->mutable_spec()->mutable_level_sampler()->add_weights(1);
  Write(folder / "sampler", {Message(sampled), Message(sampler), Message(Step(0, {-1, 3}))});
  Write(
      folder / "rendered",
      {Message(Start("maze", 2)), Message(RenderOf(v1::FRAME_VIEW_HUMAN, 32, v1::FRAME_FORMAT_PNG)),
       Message(RenderOf(v1::FRAME_VIEW_AGENT, 0, v1::FRAME_FORMAT_RGB)),
       Message(RenderOf(v1::FRAME_VIEW_LEVEL, 16, v1::FRAME_FORMAT_UNSPECIFIED))});
}

// `snapshot`: of maze.
void WriteStates(const std::filesystem::path& folder, const std::string& snapshot) {
  v1::RunPoolRequest restored = Start("maze", 2);
  v1::State& state = *restored.mutable_start()->add_states();
  state.set_environment(1);
  state.set_snapshot(snapshot);
  v1::RunPoolRequest save;
  save.mutable_save_states()->add_environments(1);
  save.mutable_save_states()->add_environments(0);
  v1::RunPoolRequest save_all;
  save_all.mutable_save_states();
  v1::RunPoolRequest clone;
  clone.mutable_clone_states()->add_pairs()->set_source_environment(1);
  v1::RunPoolRequest restore;
  *restore.mutable_restore_states()->add_states() = state;
  Write(folder / "states", {Message(restored), Message(save), Message(clone),
                            Message(Step(0, {3, 3})), Message(restore), Message(save_all)});
}

void WriteEnds(const std::filesystem::path& folder) {
  v1::RunPoolRequest named = Start("maze", 2);
  named.mutable_start()->set_pool_id("b");
  Write(folder / "several", {Message(named), Message(Step(0, {1, 2})), kMark, Message(named), kMark,
                             Message(Start("bigfish", 1)), Message(Step(0, {1}))});
  Write(folder / "cancelled", {Message(named), Message(Step(0, {1, 2})), kMark, kMark,
                               Message(Start("maze", 1)), Message(Step(0, {1}))});
  Write(folder / "garbage",
        {Message(named), Message(Step(0, {1, 2})), Message(Step(0, {2, 1})), {false, "\x12\xff"}});
  Write(folder / "faults", {Message(named), Message(Step(1, {1, 2})), {false, "\x12\xff"}});
  Write(folder / "again", {Message(named), Message(named)});
  Write(folder / "no_start", {Message(Step(0, {1, 2})), Message(named)});
  Write(folder / "empty", {Message(named), {false, ""}});
}

}  // namespace
}  // namespace procgen

int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::cerr << "usage: procgen-make-request-corpus FOLDER\n";
    return procgen::kBadUse;
  }
  const std::filesystem::path folder = arguments[1];
  for (const char* kind : {"request", "run"}) {
    std::filesystem::create_directories(folder / kind);
  }
  std::ifstream file(folder / "state" / "maze_easy.pgst", std::ios::binary);
  const std::string snapshot(std::istreambuf_iterator<char>(file), {});
  procgen::WriteCalls(folder / "request");
  procgen::WritePlays(folder / "run");
  procgen::WriteStates(folder / "run", snapshot);
  procgen::WriteEnds(folder / "run");
  return 0;
}
