// procgen-make-request-corpus FOLDER: writes the seed inputs of request_fuzz, stream_fuzz and
// dm_env_rpc_fuzz to FOLDER/request, FOLDER/stream and FOLDER/dm_env_rpc: valid requests, and some
// that are nearly valid.

#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "dm_env_rpc/v1/dm_env_rpc.pb.h"
#include "dm_env_rpc/v1/extensions/properties.pb.h"
#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/cluster.pb.h"
#include "procgen/v1/pools.pb.h"
#include "procgen/v1/render.pb.h"
#include "procgen/v1/states.pb.h"
#include "procgen/v1/step.pb.h"
#include "tests/fuzz/fuzzed_server.h"
#include "tests/fuzz/request_methods.h"

namespace procgen {
namespace {

void Write(const std::filesystem::path& path, const std::vector<Piece>& pieces) {
  std::ofstream(path, std::ios::binary) << InputOf(pieces);
}

template <typename Message>
Piece Call(RequestMethod method, const Message& message) {
  return {false, std::string(1, static_cast<char>(method)) + message.SerializeAsString()};
}

v1::CreatePoolRequest CreateRequest() {
  v1::CreatePoolRequest request;
  request.set_pool_id("c");
  v1::PoolSpec* spec = request.mutable_spec();
  spec->add_games("bigfish");
  spec->add_games("maze");
  spec->set_env_count(2);
  spec->mutable_options()->set_distribution_mode(v1::DISTRIBUTION_MODE_EASY);
  spec->mutable_options()->set_num_levels(5);
  spec->mutable_options()->set_start_level(3);
  spec->mutable_options()->set_rand_seed(9);
  spec->set_autoreset_mode(v1::AUTORESET_MODE_NEXT_STEP);
  spec->mutable_observation_format()->set_color(v1::COLOR_GRAYSCALE);
  spec->mutable_observation_format()->set_layout(v1::LAYOUT_CHW);
  spec->mutable_observation_format()->set_size_px(20);
  spec->mutable_observation_format()->set_frame_stack(2);
  return request;
}

void WritePoolCalls(const std::filesystem::path& folder) {
  v1::GetPoolRequest get;
  get.set_name("pools/c");
  v1::DeletePoolRequest remove;
  remove.set_name("pools/c");
  v1::RenewPoolRequest renew;
  renew.set_name("pools/a");
  renew.mutable_lease_duration()->set_seconds(5);
  v1::ListPoolsRequest list;
  list.set_page_size(1);
  list.set_page_token("1");
  Write(folder / "pools",
        {Call(kCreatePool, CreateRequest()), Call(kGetPool, get), Call(kListPools, list),
         Call(kRenewPool, renew), Call(kDeletePool, remove), Call(kDeletePool, remove)});
  v1::CreatePoolRequest sampled = CreateRequest();
  sampled.mutable_spec()->mutable_level_sampler()->add_level_seeds(7);
  sampled.mutable_spec()->mutable_level_sampler()->add_weights(1);
  Write(folder / "sampler", {Call(kCreatePool, sampled)});
  v1::CreatePoolRequest part = CreateRequest();
  part.mutable_spec()->set_first_env(2);
  part.mutable_spec()->set_total_env_count(8);
  part.mutable_spec()->set_transport(v1::TRANSPORT_SHARED_MEMORY);
  part.mutable_spec()->mutable_lease_duration()->set_seconds(2);
  Write(folder / "part", {Call(kCreatePool, part)});
  Write(folder / "catalog",
        {Call(kGetCatalog, v1::GetCatalogRequest()), Call(kGetLoad, v1::GetLoadRequest())});
}

void WriteStateCalls(const std::filesystem::path& folder, const std::string& snapshot) {
  v1::SaveStatesRequest save;
  save.set_pool("pools/b");
  save.add_environments(2);
  save.add_environments(0);
  save.set_response_bytes_max(65536);
  v1::CloneStatesRequest clone;
  clone.set_pool("pools/a");
  clone.set_source_pool("pools/a");
  clone.add_pairs()->set_source_environment(1);
  v1::RestoreStatesRequest restore;
  restore.set_pool("pools/a");
  restore.add_states()->set_environment(1);
  restore.mutable_states(0)->set_snapshot(snapshot);
  v1::RenderEnvironmentsRequest render;
  render.set_pool("pools/a");
  render.add_environments(1);
  render.set_size_px(32);
  Write(folder / "states", {Call(kSaveStates, save), Call(kCloneStates, clone),
                            Call(kRestoreStates, restore), Call(kRenderEnvironments, render)});
  clone.set_source_server("127.0.0.1:1");
  v1::WatchPoolRequest watch;
  watch.set_pool("pools/a");
  Write(folder / "cluster",
        {Call(kListNodes, v1::ListNodesRequest()), Call(kWatchNodes, v1::WatchNodesRequest())});
  Write(folder / "elsewhere", {Call(kCloneStates, clone), Call(kWatchPool, watch)});
  watch.add_environments(1);
  watch.set_size_px(64);
  watch.set_frames_per_second_max(60);
  v1::WatchPoolRequest smooth = watch;
  smooth.set_size_px(32);
  smooth.set_format(v1::FRAME_FORMAT_PNG);
  smooth.set_response_bytes_max(65536);
  v1::GetEpisodeRequest last;
  last.set_pool("pools/a");
  v1::GetEpisodeRequest current = last;
  current.set_environment(1);
  current.set_selector(v1::EPISODE_SELECTOR_CURRENT);
  Write(folder / "watching", {Call(kWatchPool, watch), Call(kWatchPool, smooth)});
  Write(folder / "episodes", {Call(kGetEpisode, last), Call(kGetEpisode, current)});
}

const Piece kMark = {true, ""};

Piece Message(const v1::StepPoolRequest& message) { return {false, message.SerializeAsString()}; }

v1::StepPoolRequest Attach(const std::string& pool, int32_t in_flight) {
  v1::StepPoolRequest request;
  request.mutable_attach()->set_pool(pool);
  request.mutable_attach()->set_requests_in_flight_max(in_flight);
  return request;
}

v1::StepPoolRequest Step(int64_t number, const std::vector<int32_t>& actions) {
  v1::StepPoolRequest request;
  request.set_sequence_number(number);
  request.mutable_step()->mutable_actions()->Add(actions.begin(), actions.end());
  return request;
}

void WriteStreams(const std::filesystem::path& folder) {
  v1::StepPoolRequest observe;
  observe.set_sequence_number(1);
  observe.mutable_observe();
  v1::StepPoolRequest full = Step(3, {4});
  full.set_acknowledged_sequence_number(1);
  full.add_released_batches(0);
  full.mutable_step()->mutable_slice()->set_first_env(1);
  full.mutable_step()->mutable_slice()->set_env_count(1);
  full.mutable_step()->set_repeat_count(3);
  full.mutable_step()->set_observation(v1::OBSERVATION_NONE);
  full.mutable_step()->set_with_final_observations(true);
  full.mutable_step()->add_next_levels()->set_environment(1);
  full.mutable_step()->mutable_next_levels(0)->set_level_seed(77);
  full.mutable_step()->add_resets()->set_environment(1);
  v1::StepPoolRequest reset;
  reset.set_sequence_number(4);
  reset.mutable_reset()->add_resets()->set_environment(0);
  reset.mutable_reset()->mutable_resets(0)->set_level_seed(5);
  Write(folder / "learner", {Message(Attach("pools/a", 0)), Message(observe),
                             Message(Step(2, {4, 7})), Message(full), Message(reset)});
  Write(folder / "disabled",
        {Message(Attach("pools/b", 4)), Message(Step(1, {-1, 4, 4})), Message(Step(2, {4, 4, 4}))});
  v1::StepPoolRequest sampler;
  sampler.set_sequence_number(1);
  sampler.mutable_level_sampler()->add_level_seeds(3);
  Write(folder / "sampler", {Message(Attach("pools/a", 1)), Message(sampler)});
  v1::StepPoolRequest resume = Attach("pools/a", 2);
  resume.mutable_attach()->set_resumable(true);
  resume.mutable_attach()->set_take_over(true);
  resume.mutable_attach()->set_response_bytes_max(65536);
  v1::StepPoolRequest acknowledging = Step(2, {3, 4});
  acknowledging.set_acknowledged_sequence_number(1);
  Write(folder / "resume", {Message(resume), Message(Step(1, {1, 2})), Message(Step(1, {1, 2})),
                            Message(Step(2, {3, 4})), Message(Step(1, {1, 2}))});
  Write(folder / "broken", {Message(resume), Message(Step(1, {1, 2})), kMark, kMark,
                            Message(resume), Message(Step(1, {1, 2})), Message(Step(2, {3, 4}))});
  Write(folder / "taken_over", {Message(resume), Message(Step(1, {1, 2})), kMark, Message(resume),
                                kMark, Message(resume), Message(Step(1, {1, 2}))});
  Write(folder / "acknowledged", {Message(resume), Message(Step(1, {1, 2})), Message(acknowledging),
                                  Message(Step(1, {1, 2}))});
  Write(folder / "forgotten",
        {Message(resume), Message(Step(1, {1, 2})), kMark, kMark, Message(Attach("pools/a", 1)),
         Message(Step(2, {3, 4})), Message(Step(1, {1, 2}))});
  Write(folder / "cancelled",
        {Message(Attach("pools/a", 2)), Message(Step(1, {1, 2})), kMark, kMark});
  Write(folder / "garbage", {Message(Attach("pools/a", 2)), {false, "\x0a\xff\xff"}});
  Write(folder / "again", {Message(Attach("pools/a", 2)), Message(Attach("pools/a", 2))});
}

namespace dm = ::dm_env_rpc::v1;
namespace dm_properties = ::dm_env_rpc::v1::extensions::properties;

Piece Message(const dm::EnvironmentRequest& message) {
  return {false, message.SerializeAsString()};
}

Piece CreateWorld(const std::string& id, int32_t env_count) {
  dm::EnvironmentRequest request;
  auto& settings = *request.mutable_create_world()->mutable_settings();
  settings["env_name"].mutable_strings()->add_array("maze");
  settings["distribution_mode"].mutable_strings()->add_array("easy");
  settings["rand_seed"].mutable_int64s()->add_array(3);
  settings["pool_id"].mutable_strings()->add_array(id);
  if (env_count > 0) {
    settings["num_envs"].mutable_int64s()->add_array(env_count);
  }
  return Message(request);
}

Piece JoinWorld(const std::string& id) {
  dm::EnvironmentRequest request;
  request.mutable_join_world()->set_world_name("pools/" + id);
  return Message(request);
}

Piece Act(const std::vector<int32_t>& actions, const std::vector<uint64_t>& observations) {
  dm::EnvironmentRequest request;
  dm::Tensor& action = (*request.mutable_step()->mutable_actions())[1];
  action.mutable_int32s()->mutable_array()->Add(actions.begin(), actions.end());
  if (actions.size() > 1) {
    action.add_shape(static_cast<int32_t>(actions.size()));
  }
  request.mutable_step()->mutable_requested_observations()->Add(observations.begin(),
                                                                observations.end());
  return Message(request);
}

Piece Property(const dm_properties::PropertyRequest& property) {
  dm::EnvironmentRequest request;
  request.mutable_extension()->PackFrom(property);
  return Message(request);
}

void WriteDmEnvRpcSessions(const std::filesystem::path& folder, const std::string& snapshot) {
  dm::EnvironmentRequest reset;
  (*reset.mutable_reset()->mutable_settings())["level_seed"].mutable_int64s()->add_array(9);
  dm::EnvironmentRequest reset_world;
  reset_world.mutable_reset_world()->set_world_name("pools/w");
  dm::EnvironmentRequest leave;
  leave.mutable_leave_world();
  dm::EnvironmentRequest destroy;
  destroy.mutable_destroy_world()->set_world_name("pools/w");
  Write(folder / "single",
        {CreateWorld("w", 0), JoinWorld("w"), Act({4}, {1, 2, 3}), Act({7}, {2}), Message(reset),
         Act({4}, {3}), Message(reset_world), Message(leave), Message(destroy)});
  Write(folder / "batch", {CreateWorld("w", 2), JoinWorld("w"), Act({4, 4}, {1, 9, 10, 11}),
                           Act({-1, 7}, {2, 8}), Message(reset), Act({4, 4}, {3})});
  Write(folder / "pools", {JoinWorld("a"), Act({4, 4}, {}), Message(leave), JoinWorld("b"),
                           Act({4, 4, 4}, {1}), Act({-1, 4, 4}, {}), Act({4, 4, 4}, {})});
  dm_properties::PropertyRequest list;
  list.mutable_list_property();
  dm_properties::PropertyRequest read;
  read.mutable_read_property()->set_key("state.1");
  dm_properties::PropertyRequest write;
  write.mutable_write_property()->set_key("state.0");
  write.mutable_write_property()->mutable_value()->mutable_uint8s()->set_array(snapshot);
  write.mutable_write_property()->mutable_value()->add_shape(-1);
  dm_properties::PropertyRequest next;
  next.mutable_write_property()->set_key("next_level_seed.0");
  next.mutable_write_property()->mutable_value()->mutable_int32s()->add_array(5);
  Write(folder / "properties", {JoinWorld("a"), Property(list), Property(read), Property(write),
                                Property(next), Act({4, 4}, {3}), Act({4, 4}, {3})});
  Write(folder / "several",
        {JoinWorld("a"), kMark, JoinWorld("a"), kMark, kMark, Message(leave), JoinWorld("b")});
  Write(folder / "garbage", {{false, "\x0a\xff\xff"}, {false, ""}, JoinWorld("a")});
}

}  // namespace
}  // namespace procgen

int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::cerr << "Usage: procgen-make-request-corpus FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = arguments[1];
  for (const char* kind : {"request", "stream", "dm_env_rpc"}) {
    std::filesystem::create_directories(folder / kind);
  }
  std::ifstream file(folder / "state" / "maze_easy.pgst", std::ios::binary);
  const std::string snapshot(std::istreambuf_iterator<char>(file), {});
  procgen::WritePoolCalls(folder / "request");
  procgen::WriteStateCalls(folder / "request", snapshot);
  procgen::WriteStreams(folder / "stream");
  procgen::WriteDmEnvRpcSessions(folder / "dm_env_rpc", snapshot);
  return 0;
}
