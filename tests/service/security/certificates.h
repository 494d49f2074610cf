#ifndef TESTS_SERVICE_SECURITY_CERTIFICATES_H_
#define TESTS_SERVICE_SECURITY_CERTIFICATES_H_

#include <string>

#include "tests/temporary_folder.h"

namespace procgen {

// A temporary folder with certificates made by openssl and other files of the test. The destructor
// removes it.
class Certificates {
 public:
  // Makes NAME.pem and NAME.key of a certificate authority.
  void MakeAuthority(const std::string& name) const;
  // Makes NAME.pem and NAME.key: `authority` signs the subject ("/CN=...") with these alternative
  // names for `days`. -1: it has expired.
  void Make(const std::string& authority, const std::string& name, const std::string& subject,
            const std::string& alternative_names, int days = 1) const;
  // Makes a server certificate for localhost and 127.0.0.1.
  void MakeServer(const std::string& authority, const std::string& name) const;

  std::string Path(const std::string& file) const { return folder_.At(file); }
  std::string Read(const std::string& file) const;
  // Writes a file that only its owner can read, in place.
  void Write(const std::string& file, const std::string& text) const;
  // Replaces a file atomically.
  void Replace(const std::string& file, const std::string& text) const;

 private:
  void Run(const std::string& command) const;

  TemporaryFolder folder_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_SECURITY_CERTIFICATES_H_
