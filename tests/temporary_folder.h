#ifndef TESTS_TEMPORARY_FOLDER_H_
#define TESTS_TEMPORARY_FOLDER_H_

#include <cstdlib>
#include <filesystem>
#include <string>

#include "gtest/gtest.h"

namespace procgen {

// A folder of the test's own, gone with all that is in it when this ends: tests run side by side,
// those of other checkouts, too.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_(testing::TempDir() + "/procgen-test-XXXXXX") {
    EXPECT_NE(mkdtemp(path_.data()), nullptr) << path_;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }
  // The path of what is, or will be, in it.
  std::string At(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace procgen

#endif  // TESTS_TEMPORARY_FOLDER_H_
