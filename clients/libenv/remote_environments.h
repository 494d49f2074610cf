#ifndef CLIENTS_LIBENV_REMOTE_ENVIRONMENTS_H_
#define CLIENTS_LIBENV_REMOTE_ENVIRONMENTS_H_

#include <cstdint>
#include <memory>
#include <string>

#include "clients/libenv/environments.h"
#include "envcore/pool/pool.h"
#include "procgen_client/client.h"

namespace procgen {

// Environments on a server: a pool that this creates there and deletes at its end. Act sends the
// step, Observe receives the answer. The server also renders the human views.
class RemoteEnvironments final : public Environments {
 public:
  // `address`: "host:port" or "unix:path". Errors: UNAVAILABLE no server answers within
  // kConnectTimeout; those of the server.
  static absl::StatusOr<std::unique_ptr<RemoteEnvironments>> Create(const std::string& address,
                                                                    const PoolOptions& options);
  ~RemoteEnvironments() override;
  RemoteEnvironments(const RemoteEnvironments&) = delete;
  RemoteEnvironments& operator=(const RemoteEnvironments&) = delete;

  absl::Status Act(absl::Span<const int32_t> actions) override;
  absl::StatusOr<EnvironmentValues> Observe() override;
  absl::Status Render(int32_t environment, absl::Span<uint8_t> frame) override;
  absl::StatusOr<std::string> SaveState(int32_t environment) override;
  absl::Status RestoreState(int32_t environment, absl::string_view snapshot) override;

 private:
  RemoteEnvironments(std::unique_ptr<procgen_client::Client> client, std::string pool);

  // Receives the answer to the last step, if one is outstanding.
  absl::Status Wait();

  const std::unique_ptr<procgen_client::Client> client_;
  const std::string pool_;
  std::unique_ptr<procgen_client::StepStream> stream_;
  procgen_client::Batch batch_;
  bool is_stepping_ = false;
};

}  // namespace procgen

#endif  // CLIENTS_LIBENV_REMOTE_ENVIRONMENTS_H_
