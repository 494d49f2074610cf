#include "clients/top/node_table.h"

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "clients/top/text_table.h"

namespace procgen_top {
namespace {

namespace v1 = procgen::v1;

const char* StateOf(const v1::Node& node) {
  if (node.draining()) {
    return "draining";
  }
  return node.healthy() ? "serving" : "not serving";
}

// "40/128"; "-" for fleet servers, which step no environments themselves.
std::string EnvironmentsOf(const v1::Node& node) {
  return node.environment_capacity() == 0
             ? "-"
             : absl::StrCat(node.env_count(), "/", node.environment_capacity());
}

std::vector<std::string> RowOf(const v1::Node& node, bool is_local) {
  return {absl::StrCat(absl::CHexEscape(node.name()), is_local ? " *" : ""),
          absl::CHexEscape(node.address()),
          absl::CHexEscape(node.server_version()),
          node.role() == v1::NODE_ROLE_FLEET ? "fleet" : "host",
          StateOf(node),
          EnvironmentsOf(node),
          absl::StrCat(node.pool_count()),
          absl::StrCat(node.stream_count()),
          absl::StrFormat("%.0f", node.steps_per_second())};
}

}  // namespace

std::vector<std::string> NodeTableOf(const v1::ListNodesResponse& cluster) {
  if (cluster.cluster().empty()) {
    return {};
  }
  std::vector<std::vector<std::string>> rows;
  for (const v1::Node& node : cluster.nodes()) {
    rows.push_back(RowOf(node, node.name() == cluster.local_node()));
  }
  std::vector<std::string> lines = AlignedLines({{"NODE"},
                                                 {"ADDRESS"},
                                                 {"VERSION"},
                                                 {"ROLE"},
                                                 {"STATE"},
                                                 {"ENVS"},
                                                 {"POOLS"},
                                                 {"STREAMS"},
                                                 {"STEPS/S"}},
                                                rows);
  lines.insert(lines.begin(),
               absl::StrFormat("%-9s %s   nodes %d", "cluster", absl::CHexEscape(cluster.cluster()),
                               cluster.nodes_size()));
  return lines;
}

}  // namespace procgen_top
