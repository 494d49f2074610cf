#ifndef SERVER_RPC_CATALOG_SERVICE_H_
#define SERVER_RPC_CATALOG_SERVICE_H_

#include "procgen/v1/catalog.grpc.pb.h"
#include "server/rpc/caller.h"
#include "server/session/sessions.h"

namespace procgen {

// CatalogService: tells what there is. The catalog is written once, at the start.
class CatalogServiceImpl final
    : public v1::CatalogService::WithRawCallbackMethod_GetCatalog<
          v1::CatalogService::WithRawCallbackMethod_GetLoad<v1::CatalogService::Service>> {
 public:
  // `sessions` and `callers` must outlive this.
  CatalogServiceImpl(const Sessions* sessions, const Callers* callers);

  grpc::ServerUnaryReactor* GetCatalog(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetLoad(grpc::CallbackServerContext* context,
                                    const grpc::ByteBuffer* request,
                                    grpc::ByteBuffer* response) override;

 private:
  const Sessions* const sessions_;
  const Callers* const callers_;
  const v1::Catalog catalog_;
};

}  // namespace procgen

#endif  // SERVER_RPC_CATALOG_SERVICE_H_
