#ifndef TESTS_SERVICE_SERVER_PROCESS_H_
#define TESTS_SERVICE_SERVER_PROCESS_H_

#include <sys/types.h>

#include <cstdio>
#include <string>
#include <vector>

namespace procgen {

// A procgen-server process with `flags`. Standard output and standard error are read as one. The
// destructor kills it.
class ServerProcess {
 public:
  explicit ServerProcess(const std::vector<std::string>& flags);
  ~ServerProcess();
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  // The address that it prints when it accepts connections.
  std::string Address();

  void Signal(int signal) const;
  pid_t process_id() const { return process_; }

  // Waits until the process ends. Returns the exit status, or -1 if a signal ended it.
  int Wait();

  // The output before the address.
  const std::string& beginning() const { return beginning_; }
  // The output after the address.
  const std::string& rest() const { return rest_; }

 private:
  bool ReadLine(std::string* line);

  pid_t process_ = -1;
  FILE* output_ = nullptr;
  std::string beginning_;
  std::string rest_;
};

}  // namespace procgen

#endif  // TESTS_SERVICE_SERVER_PROCESS_H_
