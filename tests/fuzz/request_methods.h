#ifndef TESTS_FUZZ_REQUEST_METHODS_H_
#define TESTS_FUZZ_REQUEST_METHODS_H_

namespace procgen {

// The methods that request_fuzz calls. Inputs contain their indices, so append new ones.
inline constexpr const char* kMethods[] = {
    "/procgen.v1.CatalogService/GetCatalog", "/procgen.v1.CatalogService/GetLoad",
    "/procgen.v1.PoolService/GetPool",       "/procgen.v1.PoolService/ListPools",
    "/procgen.v1.PoolService/WatchPool",     "/procgen.v1.PoolService/GetEpisode",
    "/procgen.v1.ClusterService/ListNodes",  "/procgen.v1.PoolService/PausePool",
    "/procgen.v1.PoolService/ListEpisodes",  "/procgen.v1.PoolService/GetPoolHistory",
};

enum RequestMethod {
  kGetCatalog,
  kGetLoad,
  kGetPool,
  kListPools,
  kWatchPool,
  kGetEpisode,
  kListNodes,
  kPausePool,
  kListEpisodes,
  kGetPoolHistory,
};

}  // namespace procgen

#endif  // TESTS_FUZZ_REQUEST_METHODS_H_
