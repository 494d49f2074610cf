#ifndef TESTS_SERVICE_FLEET_TEST_FLEET_H_
#define TESTS_SERVICE_FLEET_TEST_FLEET_H_

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "procgen_client/client.h"
#include "tests/service/server_process.h"
#include "tests/temporary_folder.h"

namespace procgen {

// A real cluster on this machine: nodes and a fleet server, each a process, that discover each
// other with Cyclone DDS. The caller injects faults into the processes by name.
class TestFleet {
 public:
  // `fleet_flags`: added to the flags of the cluster.
  explicit TestFleet(std::vector<std::string> fleet_flags = {});

  void StartNode(const std::string& name, const std::vector<std::string>& node_flags = {});
  // Sends SIGKILL and removes the node.
  void KillNode(const std::string& name);
  ServerProcess& node(const std::string& name) { return *nodes_.at(name); }
  // Releases the process to the caller, which can wait for its end.
  std::unique_ptr<ServerProcess> TakeNode(const std::string& name);

  // Starts the fleet server and waits until it lists `node_count` nodes. A restart after KillFleet
  // or StopFleet uses the same address.
  void StartFleet(size_t node_count);
  void KillFleet();
  // Sends SIGTERM and waits for the end.
  void StopFleet();
  const std::string& address() const { return address_; }
  // REQUIRES: StartFleet was called.
  pid_t fleet_process_id() const { return fleet_->process_id(); }
  std::unique_ptr<procgen_client::Client> Connect() const;

  // The test's folder.
  std::string folder() const { return folder_.path(); }

 private:
  static std::string ClusterName();
  std::vector<std::string> FlagsOf(const std::string& name) const;

  const TemporaryFolder folder_;
  const std::vector<std::string> fleet_flags_;
  const int32_t domain_;
  std::map<std::string, std::unique_ptr<ServerProcess>> nodes_;
  std::unique_ptr<ServerProcess> fleet_;
  std::string address_ = "127.0.0.1:0";
};

}  // namespace procgen

#endif  // TESTS_SERVICE_FLEET_TEST_FLEET_H_
