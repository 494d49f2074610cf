#include "server/make_credentials.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <system_error>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "openssl/ec.h"
#include "openssl/evp.h"
#include "openssl/pem.h"
#include "openssl/rand.h"
#include "openssl/x509.h"
#include "openssl/x509v3.h"
#include "server/rpc/auth/token_file.h"

namespace procgen {
namespace {

using CertificatePointer = std::unique_ptr<X509, decltype(&X509_free)>;
using KeyPointer = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
using BioPointer = std::unique_ptr<BIO, decltype(&BIO_free)>;
using ExtensionPointer = std::unique_ptr<X509_EXTENSION, decltype(&X509_EXTENSION_free)>;

constexpr int64_t kSecondsPerDay = 24 * 3600;
constexpr int64_t kAuthorityDays = 3650;
constexpr int64_t kServerDays = 365;
constexpr size_t kTokenBytes = 32;
constexpr size_t kHostLengthMax = 253;
constexpr mode_t kPrivate = S_IRUSR | S_IWUSR;
constexpr mode_t kPublic = kPrivate | S_IRGRP | S_IROTH;

struct NewFile {
  const char* name;
  std::string text;
  mode_t mode;
};

struct Extension {
  int id;
  std::string value;
};

bool IsIpAddress(const std::string& host) {
  std::array<uint8_t, sizeof(in6_addr)> bytes = {};
  return inet_pton(AF_INET, host.c_str(), bytes.data()) == 1 ||
         inet_pton(AF_INET6, host.c_str(), bytes.data()) == 1;
}

bool IsHostName(absl::string_view host) {
  return !host.empty() && host.size() <= kHostLengthMax && host.front() != '.' &&
         std::all_of(host.begin(), host.end(), [](unsigned char letter) {
           return absl::ascii_isalnum(letter) || letter == '.' || letter == '-';
         });
}

absl::Status CheckOptions(const CredentialsOptions& options) {
  if (options.hosts.empty()) {
    return absl::InvalidArgumentError(
        "--for is missing, allowed: the names and addresses by which learners connect, "
        "comma-separated");
  }
  for (const std::string& host : options.hosts) {
    if (!IsIpAddress(host) && !IsHostName(host)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--for has '", host, "', allowed: DNS names and IP addresses, without ports"));
    }
  }
  const auto parsed = ParseTokens(absl::StrCat(options.owner, " ", std::string(kTokenBytes, 'x')));
  if (!parsed.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--owner is '", options.owner, "', allowed: 1 to ", kOwnerLengthMax,
                     " printable ASCII characters without spaces and without #"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> RandomHex(size_t bytes) {
  std::string random(bytes, '\0');
  if (RAND_bytes(reinterpret_cast<uint8_t*>(random.data()), static_cast<int>(bytes)) != 1) {
    return absl::InternalError("--make_credentials: OpenSSL has no random numbers");
  }
  return absl::BytesToHexString(random);
}

// Makes a certificate of `key` that `issuer` signs with `issuer_key`. Null `issuer`: itself. Null:
// OpenSSL failed.
CertificatePointer MakeCertificate(EVP_PKEY* key, const std::string& name, int64_t days,
                                   X509* issuer, EVP_PKEY* issuer_key,
                                   const std::vector<Extension>& extensions) {
  CertificatePointer made(X509_new(), &X509_free);
  X509* const certificate = made.get();
  X509* const signer = issuer == nullptr ? certificate : issuer;
  X509_set_version(certificate, X509_VERSION_3);
  const absl::StatusOr<std::string> serial = RandomHex(8);
  if (!serial.ok()) {
    return {nullptr, &X509_free};
  }
  BIGNUM* number = nullptr;
  BN_hex2bn(&number, serial->c_str());
  BN_to_ASN1_INTEGER(number, X509_get_serialNumber(certificate));
  BN_free(number);
  X509_gmtime_adj(X509_getm_notBefore(certificate), -kSecondsPerDay);  // for clocks that are late
  X509_gmtime_adj(X509_getm_notAfter(certificate), days * kSecondsPerDay);
  X509_set_pubkey(certificate, key);
  X509_NAME_add_entry_by_txt(X509_get_subject_name(certificate), "CN", MBSTRING_UTF8,
                             reinterpret_cast<const uint8_t*>(name.c_str()), -1, -1, 0);
  X509_set_issuer_name(certificate, X509_get_subject_name(signer));
  X509V3_CTX context;
  X509V3_set_ctx(&context, signer, certificate, nullptr, nullptr, 0);
  for (const Extension& each : extensions) {
    const ExtensionPointer extension(
        X509V3_EXT_conf_nid(nullptr, &context, each.id, each.value.c_str()), &X509_EXTENSION_free);
    if (extension == nullptr || X509_add_ext(certificate, extension.get(), -1) != 1) {
      return {nullptr, &X509_free};
    }
  }
  if (X509_sign(certificate, issuer_key, EVP_sha256()) == 0) {
    return {nullptr, &X509_free};
  }
  return made;
}

std::string TextOf(BIO* bio) {
  char* text = nullptr;
  const auto size = static_cast<size_t>(BIO_get_mem_data(bio, &text));
  return {text, size};
}

std::string PemOf(X509* certificate) {
  const BioPointer bio(BIO_new(BIO_s_mem()), &BIO_free);
  PEM_write_bio_X509(bio.get(), certificate);
  return TextOf(bio.get());
}

std::string PemOf(EVP_PKEY* key) {
  const BioPointer bio(BIO_new(BIO_s_mem()), &BIO_free);
  PEM_write_bio_PrivateKey(bio.get(), key, nullptr, nullptr, 0, nullptr, nullptr);
  return TextOf(bio.get());
}

absl::StatusOr<std::vector<NewFile>> MakeFiles(const CredentialsOptions& options,
                                               const std::string& token) {
  const KeyPointer ca_key(EVP_EC_gen("P-256"), &EVP_PKEY_free);
  const KeyPointer server_key(EVP_EC_gen("P-256"), &EVP_PKEY_free);
  const std::string names =
      absl::StrJoin(options.hosts, ",", [](std::string* text, const std::string& host) {
        absl::StrAppend(text, IsIpAddress(host) ? "IP:" : "DNS:", host);
      });
  const CertificatePointer ca =
      MakeCertificate(ca_key.get(), "procgen authority", kAuthorityDays, nullptr, ca_key.get(),
                      {{NID_basic_constraints, "critical,CA:TRUE"},
                       {NID_key_usage, "critical,keyCertSign,cRLSign"},
                       {NID_subject_key_identifier, "hash"}});
  const CertificatePointer server =
      ca == nullptr
          ? CertificatePointer(nullptr, &X509_free)
          : MakeCertificate(server_key.get(), "procgen-server", kServerDays, ca.get(), ca_key.get(),
                            {{NID_basic_constraints, "critical,CA:FALSE"},
                             {NID_key_usage, "critical,digitalSignature"},
                             {NID_ext_key_usage, "serverAuth"},
                             {NID_authority_key_identifier, "keyid"},
                             {NID_subject_alt_name, names}});
  if (server == nullptr) {
    return absl::InternalError("OpenSSL cannot make the certificates");
  }
  return std::vector<NewFile>{{"ca.pem", PemOf(ca.get()), kPublic},
                              {"ca.key", PemOf(ca_key.get()), kPrivate},
                              {"server.pem", PemOf(server.get()), kPublic},
                              {"server.key", PemOf(server_key.get()), kPrivate},
                              {"tokens", absl::StrCat(options.owner, " ", token, "\n"), kPrivate}};
}

absl::Status Write(const std::string& path, const NewFile& file) {
  const int descriptor =
      open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, file.mode);
  const auto size = static_cast<ssize_t>(file.text.size());
  const bool is_written =
      descriptor >= 0 && write(descriptor, file.text.data(), file.text.size()) == size;
  const int error = errno;
  if (descriptor >= 0) {
    close(descriptor);
  }
  return is_written ? absl::OkStatus()
                    : absl::UnknownError(absl::StrCat("--make_credentials: ", path, ": ",
                                                      std::generic_category().message(error)));
}

std::string Explanation(const CredentialsOptions& options, const std::string& dir,
                        const std::string& token) {
  const std::string& host = options.hosts.front();
  const std::string shown = absl::StrContains(host, ':') ? absl::StrCat("[", host, "]") : host;
  return absl::StrCat(
      "# The server's flags:\n", "--address=0.0.0.0:", options.port, "\n",
      "--tls_certificate=", dir, "/server.pem\n", "--tls_key=", dir, "/server.key\n",
      "--tokens=", dir, "/tokens\n", "# The learner's environment, with a copy of ca.pem:\n",
      "export PROCGEN_SERVER=", shown, ":", options.port, "\n", "export PROCGEN_SERVER_CA=", dir,
      "/ca.pem\n", "export PROCGEN_SERVER_TOKEN=", token, "\n");
}

}  // namespace

absl::StatusOr<std::string> MakeCredentials(const CredentialsOptions& options) {
  if (absl::Status status = CheckOptions(options); !status.ok()) {
    return status;
  }
  const absl::StatusOr<std::string> token = RandomHex(kTokenBytes);
  if (!token.ok()) {
    return token.status();
  }
  const absl::StatusOr<std::vector<NewFile>> files = MakeFiles(options, *token);
  if (!files.ok()) {
    return files.status();
  }
  std::error_code error;
  const std::filesystem::path dir = std::filesystem::absolute(options.dir).lexically_normal();
  std::filesystem::create_directories(dir, error);
  if (!std::filesystem::is_directory(dir)) {
    return absl::UnknownError(absl::StrCat("--make_credentials is ", options.dir,
                                           ", which cannot be created: ", error.message()));
  }
  for (const NewFile& file : *files) {
    if (std::filesystem::exists(std::filesystem::symlink_status(dir / file.name))) {
      return absl::AlreadyExistsError(absl::StrCat(
          "--make_credentials: ", (dir / file.name).string(), " exists and is not overwritten"));
    }
  }
  for (const NewFile& file : *files) {
    if (absl::Status status = Write((dir / file.name).string(), file); !status.ok()) {
      return status;
    }
  }
  return Explanation(options, dir.string(), *token);
}

}  // namespace procgen
