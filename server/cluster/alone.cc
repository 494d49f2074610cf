// A node without a cluster, which sees only itself.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "server/cluster/cluster.h"

namespace procgen {
namespace {

class LoneNode final : public Cluster {
 public:
  explicit LoneNode(std::string node_id) : node_id_(std::move(node_id)) {}

  const std::string& name() const override { return name_; }
  const std::string& node_id() const override { return node_id_; }

  void Publish(NodeStatus status) override {
    status.node_id = node_id_;
    absl::MutexLock lock(&mutex_);
    nodes_ = {std::move(status)};
  }

  std::vector<NodeStatus> Nodes() const override {
    absl::MutexLock lock(&mutex_);
    return nodes_;
  }

 private:
  const std::string name_;  // empty
  const std::string node_id_;
  mutable absl::Mutex mutex_;
  std::vector<NodeStatus> nodes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

std::unique_ptr<Cluster> Cluster::Alone(const std::string& node_id) {
  return std::make_unique<LoneNode>(node_id);
}

}  // namespace procgen
