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

// A real cluster on this machine: nodes and a fleet server, each a process, that find each other
// over Cyclone DDS. Faults are what its owner does to the processes, by their names.
class TestFleet {
 public:
  // `fleet_flags`: besides those of the cluster.
  explicit TestFleet(std::vector<std::string> fleet_flags = {});

  void StartNode(const std::string& name, const std::vector<std::string>& node_flags = {});
  // SIGKILL, and it is gone.
  void KillNode(const std::string& name);
  ServerProcess& node(const std::string& name) { return *nodes_.at(name); }
  // Hands it over, so that its end can be waited for.
  std::unique_ptr<ServerProcess> TakeNode(const std::string& name);

  // Starts the fleet server, and waits until it sees so many nodes. Again after KillFleet or
  // StopFleet: at the same address.
  void StartFleet(size_t node_count);
  void KillFleet();
  // SIGTERM, and waits for its end.
  void StopFleet();
  const std::string& address() const { return address_; }
  // REQUIRES: it has been started.
  pid_t fleet_process_id() const { return fleet_->process_id(); }
  std::unique_ptr<procgen_client::Client> Connect() const;

  // A folder for the test.
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
