#ifndef TESTS_SERVICE_FLEET_HOSTILE_NODE_H_
#define TESTS_SERVICE_FLEET_HOSTILE_NODE_H_

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "grpcpp/server.h"
#include "procgen/v1/catalog.grpc.pb.h"
#include "procgen/v1/pools.grpc.pb.h"
#include "procgen/v1/render.grpc.pb.h"
#include "procgen/v1/states.grpc.pb.h"
#include "procgen/v1/step.grpc.pb.h"

namespace procgen {

// Changes that a hostile node makes to its responses. Null: none.
struct AnswerDamage {
  std::function<void(v1::Catalog*)> catalog;
  std::function<void(v1::Pool*)> pool;                  // of CreatePool
  std::function<void(v1::StepPoolResponse*)> attached;  // to attach
  std::function<void(v1::StepPoolResponse*)> step;      // to each later request
  std::function<void(v1::SaveStatesResponse*)> states;
  std::function<void(v1::RenderEnvironmentsResponse*)> frames;
};

// A gRPC proxy in front of a real node. It damages the node's responses while Attack is on, and
// forwards all calls that a fleet server makes. Threads: any method from any thread.
class HostileNode final {
 public:
  HostileNode(const std::string& target, AnswerDamage damage);
  ~HostileNode();

  const std::string& address() const { return address_; }
  // Turns the damage on or off.
  void Attack(bool attacks) { attacks_ = attacks; }
  // Number of damaged responses.
  int damage_count() const { return damage_count_; }

 private:
  class Catalogs;
  class Pools;
  class Steps;
  class States;
  class Renders;

  template <typename Message>
  void Apply(const std::function<void(Message*)>& damage, Message* message) {
    if (attacks_ && damage != nullptr) {
      damage(message);
      ++damage_count_;
    }
  }

  const AnswerDamage damage_;
  std::atomic<bool> attacks_ = false;
  std::atomic<int> damage_count_ = 0;
  std::unique_ptr<Catalogs> catalogs_;
  std::unique_ptr<Pools> pools_;
  std::unique_ptr<Steps> steps_;
  std::unique_ptr<States> states_;
  std::unique_ptr<Renders> renders_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_FLEET_HOSTILE_NODE_H_
