#include "server/web_flags.h"

#include <cstdint>
#include <string>
#include <vector>

#include "absl/flags/flag.h"

ABSL_FLAG(
    std::string, web_address, "",
    "where to serve the live view, play, replays and the gallery to browsers: HOST:PORT (port "
    "0: any that is free; it is logged). Empty: nowhere");
ABSL_FLAG(std::vector<std::string>, web_allowed_hosts, {},
          "names, with commas, by which browsers may ask for the pages, besides localhost and the "
          "addresses that --web_address stands for");
ABSL_FLAG(int32_t, web_viewers_max, procgen::Config().web_viewers_max,
          "pages that are open at a time");

namespace procgen {

void ReadWebFlags(Config* config) {
  config->web_address = absl::GetFlag(FLAGS_web_address);
  config->web_allowed_hosts = absl::GetFlag(FLAGS_web_allowed_hosts);
  config->web_viewers_max = absl::GetFlag(FLAGS_web_viewers_max);
}

}  // namespace procgen
