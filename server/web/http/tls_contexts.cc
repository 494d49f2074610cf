#include "server/web/http/tls_contexts.h"

#include <string>
#include <utility>

#include "boost/asio/buffer.hpp"

namespace procgen::web {
namespace {

namespace asio = boost::asio;

// Allows TLS 1.2 and 1.3 only.
std::shared_ptr<asio::ssl::context> ContextOf(const TlsFiles::Contents& contents) {
  auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_server);
  context->set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_sslv2 |
                       asio::ssl::context::no_sslv3 | asio::ssl::context::no_tlsv1 |
                       asio::ssl::context::no_tlsv1_1);
  context->use_certificate_chain(asio::buffer(contents.certificate));
  context->use_private_key(asio::buffer(contents.key), asio::ssl::context::pem);
  if (!contents.client_ca.empty()) {
    context->add_certificate_authority(asio::buffer(contents.client_ca));
    context->set_verify_mode(asio::ssl::verify_peer | asio::ssl::verify_fail_if_no_peer_cert);
  }
  return context;
}

}  // namespace

std::shared_ptr<asio::ssl::context> TlsContexts::Current() {
  if (files_ == nullptr) {
    return nullptr;
  }
  const auto [contents, version] = files_->Current();
  if (version != version_) {
    context_ = ContextOf(contents);  // the files were validated when they were read
    version_ = version;
  }
  return context_;
}

}  // namespace procgen::web
