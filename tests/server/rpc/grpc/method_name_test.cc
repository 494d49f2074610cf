#include "server/rpc/grpc/method_name.h"

#include "gtest/gtest.h"
#include "procgen/v1/catalog.pb.h"
#include "procgen/v1/cluster.pb.h"
#include "procgen/v1/pools.pb.h"
#include "procgen/v1/render.pb.h"
#include "procgen/v1/step.pb.h"

namespace procgen {
namespace {

TEST(MethodNameTest, IsTheMethodOfTheRequestType) {
  EXPECT_EQ(MethodNameOf<v1::GetLoadRequest>(), "CatalogService/GetLoad");
  EXPECT_EQ(MethodNameOf<v1::WatchNodesRequest>(), "ClusterService/WatchNodes");
  EXPECT_EQ(MethodNameOf<v1::DeletePoolRequest>(), "PoolService/DeletePool");
  EXPECT_EQ(MethodNameOf<v1::StepPoolRequest>(), "StepService/StepPool");
  EXPECT_EQ(MethodNameOf<v1::WatchPoolRequest>(), "RenderService/WatchPool");
}

}  // namespace
}  // namespace procgen
