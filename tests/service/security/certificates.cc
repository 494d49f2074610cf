#include "tests/service/security/certificates.h"

#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"

namespace procgen {
namespace {

constexpr char kNewKey[] = "-newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes";

}  // namespace

void Certificates::MakeAuthority(const std::string& name) const {
  Run(absl::StrCat("openssl req -x509 ", kNewKey, " -days 2 -subj /CN=", name, " -keyout ", name,
                   ".key -out ", name, ".pem"));
}

void Certificates::Make(const std::string& authority, const std::string& name,
                        const std::string& subject, const std::string& alternative_names,
                        int days) const {
  Write(name + ".extensions", "subjectAltName=" + alternative_names + "\n");
  Run(absl::StrCat("openssl req ", kNewKey, " -subj '", subject, "' -keyout ", name, ".key -out ",
                   name, ".request"));
  Run(absl::StrCat("openssl x509 -req -in ", name, ".request -CA ", authority, ".pem -CAkey ",
                   authority, ".key -CAcreateserial -days ", days, " -extfile ", name,
                   ".extensions -out ", name, ".pem"));
}

void Certificates::MakeServer(const std::string& authority, const std::string& name) const {
  Make(authority, name, "/CN=server", "DNS:localhost,IP:127.0.0.1");
}

std::string Certificates::Read(const std::string& file) const {
  std::ifstream stream(Path(file), std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void Certificates::Write(const std::string& file, const std::string& text) const {
  std::ofstream(Path(file), std::ios::binary) << text;
  chmod(Path(file).c_str(), S_IRUSR | S_IWUSR);
}

void Certificates::Replace(const std::string& file, const std::string& text) const {
  Write(file + ".next", text);
  std::filesystem::rename(Path(file + ".next"), Path(file));
}

void Certificates::Run(const std::string& command) const {
  EXPECT_EQ(
      std::system(absl::StrCat("cd ", folder_.path(), " && ", command, " 2>/dev/null").c_str()), 0)
      << command;
}

}  // namespace procgen
