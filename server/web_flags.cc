#include "server/web_flags.h"

#include <cstdint>
#include <string>
#include <vector>

#include "absl/flags/flag.h"

ABSL_FLAG(
    std::string, web_address, "",
    "address that serves the live view, play, replays and the gallery to browsers: HOST:PORT (port "
    "0: any free port, which is logged); empty: none");
ABSL_FLAG(std::vector<std::string>, web_allowed_hosts, {},
          "host names by which browsers may request the pages, comma-separated, besides localhost "
          "and the addresses of --web_address");
ABSL_FLAG(int32_t, web_viewers_max, procgen::Config().web_viewers_max, "open pages");

namespace procgen {

void ReadWebFlags(Config* config) {
  config->web_address = absl::GetFlag(FLAGS_web_address);
  config->web_allowed_hosts = absl::GetFlag(FLAGS_web_allowed_hosts);
  config->web_viewers_max = absl::GetFlag(FLAGS_web_viewers_max);
}

}  // namespace procgen
