#ifndef TESTS_SERVER_DM_ENV_RPC_TEST_SESSION_H_
#define TESTS_SERVER_DM_ENV_RPC_TEST_SESSION_H_

#include <map>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "absl/synchronization/notification.h"
#include "server/dm_env_rpc/dm_env_rpc_session.h"
#include "server/dm_env_rpc/properties.h"

namespace procgen {

inline dm::Tensor TextTensor(const std::string& text) {
  dm::Tensor tensor;
  tensor.mutable_strings()->add_array(text);
  return tensor;
}

inline dm::Tensor IntegerTensor(int64_t value) {
  dm::Tensor tensor;
  tensor.mutable_int64s()->add_array(value);
  return tensor;
}

inline dm::Tensor ActionTensor(int32_t action) {
  dm::Tensor tensor;
  tensor.mutable_int32s()->add_array(action);
  return tensor;
}

using SettingList = std::map<std::string, dm::Tensor>;

// A session with blocking calls.
class TestSession {
 public:
  TestSession(PoolSupervisor* supervisor, JoinedWorlds* worlds, const std::string& owner = "")
      : session_(supervisor, worlds, owner, [](const absl::Status& /*reason*/) {}) {}
  ~TestSession() { session_.End(); }
  TestSession(const TestSession&) = delete;
  TestSession& operator=(const TestSession&) = delete;

  DmEnvRpcSession& session() { return session_; }

  // A request and its response, which Send does not wait for.
  struct Pending {
    dm::EnvironmentRequest request;
    dm::EnvironmentResponse response;
    absl::Notification answered;
  };
  void Send(Pending* pending) {
    session_.Answer(pending->request, &pending->response,
                    [pending](const absl::Status& /*status*/) { pending->answered.Notify(); });
  }

  dm::EnvironmentResponse Call(const dm::EnvironmentRequest& request) {
    Pending pending;
    pending.request = request;
    Send(&pending);
    pending.answered.WaitForNotification();
    return pending.response;
  }

  dm::EnvironmentResponse Create(const SettingList& settings) {
    dm::EnvironmentRequest request;
    request.mutable_create_world()->mutable_settings()->insert(settings.begin(), settings.end());
    return Call(request);
  }

  dm::EnvironmentResponse Join(const std::string& world) {
    dm::EnvironmentRequest request;
    request.mutable_join_world()->set_world_name(world);
    return Call(request);
  }

  dm::EnvironmentResponse Step(int32_t action, const std::vector<uint64_t>& observations = {}) {
    dm::EnvironmentRequest request;
    (*request.mutable_step()->mutable_actions())[kActionUid] = ActionTensor(action);
    request.mutable_step()->mutable_requested_observations()->Assign(observations.begin(),
                                                                     observations.end());
    return Call(request);
  }

  dm::EnvironmentResponse Reset(const SettingList& settings = {}) {
    dm::EnvironmentRequest request;
    request.mutable_reset()->mutable_settings()->insert(settings.begin(), settings.end());
    return Call(request);
  }

  static dm::EnvironmentRequest ResetWorldRequest(const std::string& world) {
    dm::EnvironmentRequest request;
    request.mutable_reset_world()->set_world_name(world);
    return request;
  }

  dm::EnvironmentResponse Destroy(const std::string& world) {
    dm::EnvironmentRequest request;
    request.mutable_destroy_world()->set_world_name(world);
    return Call(request);
  }

  dm::EnvironmentResponse Write(const std::string& property, const dm::Tensor& value) {
    dm_properties::PropertyRequest written;
    written.mutable_write_property()->set_key(property);
    *written.mutable_write_property()->mutable_value() = value;
    dm::EnvironmentRequest request;
    request.mutable_extension()->PackFrom(written);
    return Call(request);
  }

  dm::EnvironmentResponse Leave() {
    dm::EnvironmentRequest request;
    request.mutable_leave_world();
    return Call(request);
  }

 private:
  DmEnvRpcSession session_;
};

}  // namespace procgen

#endif  // TESTS_SERVER_DM_ENV_RPC_TEST_SESSION_H_
