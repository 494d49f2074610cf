#ifndef TESTS_SERVICE_SECURITY_CERTIFICATES_H_
#define TESTS_SERVICE_SECURITY_CERTIFICATES_H_

#include <string>

#include "tests/temporary_folder.h"

namespace procgen {

// A folder of a test's own, with certificates that the program openssl makes there and whatever
// else the test writes. Gone with this.
class Certificates {
 public:
  // Makes NAME.pem and NAME.key that vouch for others.
  void MakeAuthority(const std::string& name) const;
  // Makes NAME.pem and NAME.key: `authority` vouches for "/CN=..." with these alternative names,
  // for `days`; -1: it has expired.
  void Make(const std::string& authority, const std::string& name, const std::string& subject,
            const std::string& alternative_names, int days = 1) const;
  // As a server on this machine has it: for localhost and 127.0.0.1.
  void MakeServer(const std::string& authority, const std::string& name) const;

  // Makes `signed_file` of `file`, which `authority` has signed (S/MIME).
  void Sign(const std::string& authority, const std::string& file,
            const std::string& signed_file) const;

  std::string Path(const std::string& file) const { return folder_.At(file); }
  std::string Read(const std::string& file) const;
  // Writes a file that only its owner can read; in place.
  void Write(const std::string& file, const std::string& text) const;
  // Puts another file in its place at once.
  void Replace(const std::string& file, const std::string& text) const;

 private:
  void Run(const std::string& command) const;

  TemporaryFolder folder_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_SECURITY_CERTIFICATES_H_
