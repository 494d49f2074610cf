#ifndef TESTS_TEMPORARY_FOLDER_H_
#define TESTS_TEMPORARY_FOLDER_H_

#include <cstdlib>
#include <filesystem>
#include <string>

#include "gtest/gtest.h"

namespace procgen {

// A new temporary folder, removed with its contents by the destructor. Its name is unique, because
// tests run concurrently, also those of other checkouts.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_(testing::TempDir() + "/procgen-test-XXXXXX") {
    EXPECT_NE(mkdtemp(path_.data()), nullptr) << path_;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }
  // The path of a file in the folder.
  std::string At(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace procgen

#endif  // TESTS_TEMPORARY_FOLDER_H_
