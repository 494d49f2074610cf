#ifndef CLIENTS_LIBENV_REMOTE_ENVIRONMENTS_H_
#define CLIENTS_LIBENV_REMOTE_ENVIRONMENTS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "clients/libenv/environments.h"
#include "envcore/pool/batch_numbers.h"
#include "envcore/pool/pool.h"
#include "procgen_client/pool.h"

namespace procgen {

// Environments on one or several servers: a pool that lives as long as this object. Act sends the
// step, Observe receives the response. The server also renders the human views.
class RemoteEnvironments final : public Environments {
 public:
  // `addresses`: "host:port" or "unix:path", or several separated by commas. Errors: UNAVAILABLE no
  // server answers within kConnectTimeout; those of the server.
  static absl::StatusOr<std::unique_ptr<RemoteEnvironments>> Create(const std::string& addresses,
                                                                    const PoolOptions& options);

  absl::Status Act(absl::Span<const int32_t> actions) override;
  absl::StatusOr<EnvironmentValues> Observe() override;
  absl::Status Render(int32_t environment, absl::Span<uint8_t> frame) override;
  absl::StatusOr<std::string> SaveState(int32_t environment) override;
  absl::Status RestoreState(int32_t environment, absl::string_view snapshot) override;

 private:
  explicit RemoteEnvironments(std::unique_ptr<procgen_client::Pool> pool);

  // Receives the response to the last step, if one is outstanding.
  absl::Status Wait();
  absl::Status ObservePool();
  Batch OwnBatch();

  std::vector<uint8_t> observations_;  // [N, 64, 64, 3]
  BatchNumbers numbers_;               // [N]
  // Destroyed first: it writes to the arrays above.
  const std::unique_ptr<procgen_client::Pool> pool_;
};

}  // namespace procgen

#endif  // CLIENTS_LIBENV_REMOTE_ENVIRONMENTS_H_
