#include "server/fleet_flags.h"

#include <string>

#include "absl/flags/flag.h"
#include "server/duration_flag.h"

ABSL_FLAG(bool, fleet, false,
          "spread pools over the nodes of --cluster instead of stepping them here");
ABSL_FLAG(std::string, state_dir, "",
          "folder where a --fleet keeps its pools across restarts; one process at a time. Empty: "
          "pools end with the process");
ABSL_FLAG(procgen::DurationFlag, fleet_failover_timeout, {procgen::FleetOptions().failover_timeout},
          "how long a request waits for nodes that can execute it; then its stream ends");
ABSL_FLAG(std::string, fleet_ca, "",
          "PEM file of the authorities that sign the nodes' certificates. Empty: plain text to the "
          "nodes");
ABSL_FLAG(std::string, fleet_certificate, "",
          "PEM file of the client certificate presented to nodes");
ABSL_FLAG(std::string, fleet_key, "", "PEM file of the key of --fleet_certificate");
ABSL_FLAG(std::string, fleet_token, "", "file with the token sent to nodes. Empty: none");

namespace procgen {

void ReadFleetFlags(Config* config) {
  config->is_fleet = absl::GetFlag(FLAGS_fleet);
  config->state_dir = absl::GetFlag(FLAGS_state_dir);
  FleetOptions& fleet = config->fleet;
  fleet.failover_timeout = absl::GetFlag(FLAGS_fleet_failover_timeout).value;
  fleet.credentials = {.ca = absl::GetFlag(FLAGS_fleet_ca),
                       .certificate = absl::GetFlag(FLAGS_fleet_certificate),
                       .key = absl::GetFlag(FLAGS_fleet_key),
                       .token = absl::GetFlag(FLAGS_fleet_token)};
}

}  // namespace procgen
