// The main program of a fuzz target that is built without libFuzzer: runs it over files.
//
//   TARGET PATH...     files, or folders, whose files run in the order of their names
//
// Exit status: that of the target; 2 if there is no input or a file cannot be read.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);

namespace {

constexpr int kBadUse = 2;

std::vector<std::filesystem::path> FilesAt(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) {
    return {path};
  }
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

int main(int argument_count, char** arguments) {
  size_t file_count = 0;
  for (int i = 1; i < argument_count; ++i) {
    for (const std::filesystem::path& path : FilesAt(arguments[i])) {
      std::ifstream file(path, std::ios::binary);
      if (!file) {
        std::cerr << "cannot read " << path << "\n";
        return kBadUse;
      }
      const std::string bytes(std::istreambuf_iterator<char>(file), {});
      // Printed before the run, because the target may not return.
      std::cout << path.string() << std::endl;
      LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
      ++file_count;
    }
  }
  std::cout << file_count << " inputs\n";
  return file_count > 0 ? 0 : kBadUse;
}
