#include "server/net/tls_files.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "openssl/err.h"
#include "openssl/pem.h"
#include "openssl/x509.h"
#include "server/logging/event_log.h"

namespace procgen {
namespace {

using CertificatePointer = std::unique_ptr<X509, decltype(&X509_free)>;
using KeyPointer = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
using BioPointer = std::unique_ptr<BIO, decltype(&BIO_free)>;

BioPointer BioOf(const std::string& pem) {
  return {BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), &BIO_free};
}

// Password callback that returns none, so that OpenSSL does not prompt for one.
int NoPassword(char* /*buffer*/, int /*size*/, int /*writes*/, void* /*unused*/) { return 0; }

std::vector<CertificatePointer> CertificatesIn(const std::string& pem) {
  std::vector<CertificatePointer> certificates;
  const BioPointer bio = BioOf(pem);
  while (X509* certificate = PEM_read_bio_X509(bio.get(), nullptr, &NoPassword, nullptr)) {
    certificates.emplace_back(certificate, &X509_free);
  }
  ERR_clear_error();  // the end of the file is an error
  return certificates;
}

KeyPointer KeyIn(const std::string& pem) {
  const BioPointer bio = BioOf(pem);
  KeyPointer key(PEM_read_bio_PrivateKey(bio.get(), nullptr, &NoPassword, nullptr), &EVP_PKEY_free);
  ERR_clear_error();
  return key;
}

absl::Status WrongFile(absl::string_view flag, const WatchedFile& file, absl::string_view reason) {
  return absl::InvalidArgumentError(absl::StrCat("--", flag, ": ", file.path(), ": ", reason));
}

absl::StatusOr<std::string> ReadFor(absl::string_view flag, WatchedFile* file) {
  absl::StatusOr<std::string> bytes = file->Read();
  if (!bytes.ok()) {
    return absl::Status(bytes.status().code(),
                        absl::StrCat("--", flag, ": ", bytes.status().message()));
  }
  return bytes;
}

}  // namespace

TlsFiles::TlsFiles(const TlsPaths& paths)
    : requires_client_certificate_(!paths.client_ca.empty()),
      certificate_(paths.certificate),
      key_(paths.key),
      client_ca_(paths.client_ca) {}

absl::StatusOr<std::shared_ptr<TlsFiles>> TlsFiles::Open(const TlsPaths& paths) {
  std::shared_ptr<TlsFiles> files(new TlsFiles(paths));
  absl::MutexLock lock(&files->mutex_);
  absl::StatusOr<Contents> contents = files->Read();
  if (!contents.ok()) {
    return contents.status();
  }
  files->contents_ = *std::move(contents);
  return files;
}

absl::StatusOr<TlsFiles::Contents> TlsFiles::Read() {
  // Reads all files even if one has an error, so that each change is reported once.
  absl::StatusOr<std::string> certificate = ReadFor("tls_certificate", &certificate_);
  absl::StatusOr<std::string> key = ReadFor("tls_key", &key_);
  absl::StatusOr<std::string> client_ca =
      requires_client_certificate_ ? ReadFor("tls_client_ca", &client_ca_) : std::string();
  for (const absl::Status& status : {certificate.status(), key.status(), client_ca.status()}) {
    if (!status.ok()) {
      return status;
    }
  }
  const std::vector<CertificatePointer> chain = CertificatesIn(*certificate);
  if (chain.empty()) {
    return WrongFile("tls_certificate", certificate_, "has no certificate in PEM");
  }
  const KeyPointer private_key = KeyIn(*key);
  if (private_key == nullptr) {
    return WrongFile("tls_key", key_, "has no private key in PEM without a password");
  }
  if (X509_check_private_key(chain.front().get(), private_key.get()) != 1) {
    ERR_clear_error();
    return WrongFile("tls_key", key_, absl::StrCat("is not the key of ", certificate_.path()));
  }
  if (requires_client_certificate_ && CertificatesIn(*client_ca).empty()) {
    return WrongFile("tls_client_ca", client_ca_, "has no certificate in PEM");
  }
  if (X509_cmp_current_time(X509_get0_notAfter(chain.front().get())) < 0) {
    LogEvent(LogLevel::kWarning, "certificate_expired",
             {{"file", certificate_.path()}, {"message", "clients will refuse it"}});
  }
  if (key_.is_world_readable()) {
    LogEvent(LogLevel::kWarning, "private_key_world_readable",
             {{"file", key_.path()}, {"message", "all users can read it; chmod o-r"}});
  }
  return Contents{*std::move(certificate), *std::move(key), *std::move(client_ca)};
}

void TlsFiles::Refresh() {
  const bool has_changed = certificate_.HasChanged() || key_.HasChanged() ||
                           (requires_client_certificate_ && client_ca_.HasChanged());
  if (has_changed) {
    absl::StatusOr<Contents> contents = Read();
    LogEvent(contents.ok() ? LogLevel::kInfo : LogLevel::kWarning,
             contents.ok() ? "certificates_reloaded" : "certificates_reload_failed",
             {{"message", std::string(contents.status().message())}});
    if (contents.ok()) {
      contents_ = *std::move(contents);
      ++version_;
    }
  }
}

std::pair<TlsFiles::Contents, int64_t> TlsFiles::Current() {
  absl::MutexLock lock(&mutex_);
  Refresh();
  return {contents_, version_};
}

}  // namespace procgen
