#include "server/rpc/auth/tls_credentials.h"

#include <string>

#include "grpc/grpc.h"

namespace procgen {
namespace {

// gRPC credentials with a replaceable certificate. gRPC's C++ interface would use a new certificate
// with the old key while only one of the files is replaced.
class ReloadedCredentials final : public grpc::ServerCredentials {
 public:
  explicit ReloadedCredentials(grpc_server_credentials* credentials) : credentials_(credentials) {}
  ~ReloadedCredentials() override { grpc_server_credentials_release(credentials_); }

  void SetAuthMetadataProcessor(
      const std::shared_ptr<grpc::AuthMetadataProcessor>& /*processor*/) override {}

 private:
  int AddPortToServer(const std::string& address, grpc_server* server) override {
    return grpc_server_add_http2_port(server, address.c_str(), credentials_);
  }

  grpc_server_credentials* const credentials_;
};

}  // namespace

std::shared_ptr<grpc::ServerCredentials> TlsCredentials::Make() {
  const grpc_ssl_client_certificate_request_type request =
      files_->requires_client_certificate()
          ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
          : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE;
  return std::make_shared<ReloadedCredentials>(grpc_ssl_server_credentials_create_with_options(
      grpc_ssl_server_credentials_create_options_using_config_fetcher(
          request, &TlsCredentials::Fetch, this)));
}

grpc_ssl_certificate_config_reload_status TlsCredentials::Fetch(
    void* credentials, grpc_ssl_server_certificate_config** config) {
  return static_cast<TlsCredentials*>(credentials)->Fetch(config);
}

grpc_ssl_certificate_config_reload_status TlsCredentials::Fetch(
    grpc_ssl_server_certificate_config** config) {
  absl::MutexLock lock(&mutex_);
  const auto [contents, version] = files_->Current();
  if (fetched_version_ == version) {
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
  }
  fetched_version_ = version;
  // gRPC requires root certificates even if it does not request client certificates.
  const std::string& roots =
      files_->requires_client_certificate() ? contents.client_ca : contents.certificate;
  const grpc_ssl_pem_key_cert_pair pair = {contents.key.c_str(), contents.certificate.c_str()};
  *config = grpc_ssl_server_certificate_config_create(roots.c_str(), &pair, 1);
  return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
}

}  // namespace procgen
