#ifndef TESTS_FUZZ_REQUEST_METHODS_H_
#define TESTS_FUZZ_REQUEST_METHODS_H_

namespace procgen {

// The methods that request_fuzz calls. Inputs contain their indices, so append new ones.
inline constexpr const char* kMethods[] = {
    "/procgen.v1.CatalogService/GetCatalog",
    "/procgen.v1.CatalogService/GetLoad",
    "/procgen.v1.PoolService/CreatePool",
    "/procgen.v1.PoolService/GetPool",
    "/procgen.v1.PoolService/ListPools",
    "/procgen.v1.PoolService/DeletePool",
    "/procgen.v1.PoolService/RenewPool",
    "/procgen.v1.StateService/SaveStates",
    "/procgen.v1.StateService/RestoreStates",
    "/procgen.v1.StateService/CloneStates",
    "/procgen.v1.RenderService/RenderEnvironments",
    "/procgen.v1.RenderService/WatchPool",
    "/procgen.v1.ClusterService/ListNodes",
    "/procgen.v1.ClusterService/WatchNodes",
    "/procgen.v1.StateService/GetEpisode",
};

enum RequestMethod {
  kGetCatalog,
  kGetLoad,
  kCreatePool,
  kGetPool,
  kListPools,
  kDeletePool,
  kRenewPool,
  kSaveStates,
  kRestoreStates,
  kCloneStates,
  kRenderEnvironments,
  kWatchPool,
  kListNodes,
  kWatchNodes,
  kGetEpisode,
};

}  // namespace procgen

#endif  // TESTS_FUZZ_REQUEST_METHODS_H_
