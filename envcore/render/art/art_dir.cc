#include "envcore/render/art/art_dir.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "envcore/render/art/png_decoding.h"
#include "envcore/status/status.h"

namespace procgen {
namespace {

// Largest number of files that an error message names. A folder of another kind has hundreds of
// missing files.
constexpr size_t kNamedFilesMax = 5;
// Upstream's largest file has 2 MB.
constexpr uintmax_t kFileBytesMax = 64 << 20;
// Limit of all images together; a decoded pixel has 4 bytes. Upstream's images have 71 million
// pixels.
constexpr int64_t kPixelsMax = 256'000'000;

StatusOr<std::string> ReadFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return NotFoundError("is missing");
  }
  const bool is_file = std::filesystem::is_regular_file(path, error);
  const uintmax_t size = is_file ? std::filesystem::file_size(path, error) : 0;
  std::string bytes;
  if (is_file && !error && size <= kFileBytesMax) {
    std::ifstream file(path, std::ios::binary);
    bytes.resize(size);
    if (file.read(bytes.data(), static_cast<std::streamsize>(size))) {
      return bytes;
    }
  }
  return InvalidArgumentError("cannot be read");
}

// Checks one image and subtracts its pixels from `pixels_left`.
Status CheckImage(absl::string_view png, const RequiredImage& required, int64_t* pixels_left) {
  const StatusOr<PngSize> size = CheckPng(png);
  if (!size.ok()) {
    return size.status();
  }
  if (required.width_px != 0 &&
      (size->width_px != required.width_px || size->height_px != required.height_px)) {
    return InvalidArgumentError(absl::StrCat("is ", size->width_px, " x ", size->height_px,
                                             " pixels, must be ", required.width_px, " x ",
                                             required.height_px));
  }
  *pixels_left -= int64_t{size->width_px} * size->height_px;
  if (*pixels_left < 0) {
    return InvalidArgumentError(absl::StrCat("is ", size->width_px, " x ", size->height_px,
                                             " pixels; all images together can have ", kPixelsMax,
                                             " pixels"));
  }
  return DecodePng(png, AlphaUse::kIgnored).status();  // AlphaUse does not affect validity
}

// Collects the errors of the files of a folder into one status.
class FileErrors {
 public:
  void Add(absl::string_view path, const Status& status) {
    any_missing_ |= status.code() == absl::StatusCode::kNotFound;
    if (count_++ < kNamedFilesMax) {
      named_.push_back(absl::StrCat(path, " ", status.message()));
    }
  }

  Status ToStatus(absl::string_view folder, size_t required_count) const {
    if (count_ == 0) {
      return OkStatus();
    }
    const std::string message = absl::StrCat(
        "art folder '", folder, "': ", count_, " of ", required_count,
        " images are missing or invalid: ", absl::StrJoin(named_, "; "),
        count_ > named_.size() ? absl::StrCat("; and ", count_ - named_.size(), " more") : "");
    return any_missing_ ? NotFoundError(message) : InvalidArgumentError(message);
  }

 private:
  std::vector<std::string> named_;
  size_t count_ = 0;
  bool any_missing_ = false;
};

}  // namespace

StatusOr<std::shared_ptr<const ArtPack>> ReadArtDir(const std::string& folder,
                                                    absl::Span<const RequiredImage> required) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    return NotFoundError(absl::StrCat("art folder '", folder, "': there is no such folder"));
  }
  // Shared with the pack, because its files are views of these bytes.
  const auto contents = std::make_shared<std::vector<std::string>>();
  contents->reserve(required.size());
  std::vector<ArtFile> files;
  FileErrors file_errors;
  int64_t pixels_left = kPixelsMax;
  for (const RequiredImage& picture : required) {
    StatusOr<std::string> bytes =
        ReadFile(std::filesystem::path(folder) / std::string(picture.path));
    const Status status = bytes.ok() ? CheckImage(*bytes, picture, &pixels_left) : bytes.status();
    if (!status.ok()) {
      file_errors.Add(picture.path, status);
      continue;
    }
    contents->push_back(*std::move(bytes));
    files.push_back({std::string(picture.path), contents->back()});
  }
  if (Status status = file_errors.ToStatus(folder, required.size()); !status.ok()) {
    return status;
  }
  return std::make_shared<const ArtPack>(ArtLayout::kUpstream, files, contents);
}

}  // namespace procgen
