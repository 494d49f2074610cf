#include "envcore/render/art/png_decoding.h"

#include <csetjmp>
#include <cstring>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "png.h"
#include "zlib.h"

namespace procgen {
namespace {

// The input of libpng and its error message.
struct Source {
  absl::string_view rest;
  char message[128] = "";
};

void ReadBytes(png_structp png, png_bytep out, size_t count) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (count > source->rest.size()) {
    png_error(png, "ends early");
  }
  std::memcpy(out, source->rest.data(), count);
  source->rest.remove_prefix(count);
}

[[noreturn]] void OnError(png_structp png, png_const_charp message) {
  auto* source = static_cast<Source*>(png_get_error_ptr(png));
  std::strncpy(source->message, message, sizeof(source->message) - 1);
  png_longjmp(png, 1);
}

void OnWarning(png_structp /*png*/, png_const_charp /*message*/) {}

const png_byte* Unsigned(absl::string_view bytes) {
  return reinterpret_cast<const png_byte*>(bytes.data());
}

// Converts everything to RGBA with 8 bits per channel. No gamma: the stored values are used.
void RequestRgba(png_structp png) {
  png_set_expand(png);
  png_set_strip_16(png);
  png_set_gray_to_rgb(png);
  png_set_add_alpha(png, 255, PNG_FILLER_AFTER);
  png_set_interlace_handling(png);
}

// Reads the whole file; returns false on an error. libpng reports errors through longjmp, so no
// object with a destructor is created here.
bool ReadImage(png_structp png, png_infop info, std::vector<uint8_t>* bytes,
               std::vector<png_bytep>* rows, int* width, int* height) {
  if (setjmp(png_jmpbuf(png)) != 0) {  // NOLINT: libpng's way of telling errors
    return false;
  }
  png_set_user_limits(png, kPngSizePxMax, kPngSizePxMax);
  png_read_info(png, info);
  RequestRgba(png);
  png_read_update_info(png, info);
  *width = static_cast<int>(png_get_image_width(png, info));
  *height = static_cast<int>(png_get_image_height(png, info));
  const size_t row_bytes = png_get_rowbytes(png, info);
  bytes->resize(row_bytes * static_cast<size_t>(*height));
  rows->resize(static_cast<size_t>(*height));
  for (size_t y = 0; y < rows->size(); ++y) {
    (*rows)[y] = bytes->data() + y * row_bytes;
  }
  png_read_image(png, rows->data());
  png_read_end(png, nullptr);
  return true;
}

uint32_t BigEndian(absl::string_view bytes) { return png_get_uint_32(Unsigned(bytes)); }

// A chunk of a PNG file.
struct Chunk {
  absl::string_view type;  // four letters
  absl::string_view content;
};

// Removes the next chunk from `rest`. Returns false if it is truncated or damaged.
bool TakeChunk(absl::string_view* rest, Chunk* chunk) {
  constexpr size_t kFrameBytes = 12;  // length, type, checksum
  if (rest->size() < kFrameBytes || BigEndian(*rest) > rest->size() - kFrameBytes) {
    return false;
  }
  const size_t length = BigEndian(*rest);
  const absl::string_view checked = rest->substr(4, 4 + length);
  const uint32_t checksum = BigEndian(rest->substr(8 + length));
  rest->remove_prefix(kFrameBytes + length);
  *chunk = {checked.substr(0, 4), checked.substr(4)};
  return crc32(0, Unsigned(checked), static_cast<uInt>(checked.size())) == checksum;
}

Image ToImage(const std::vector<uint8_t>& bytes, int width, int height, AlphaUse alpha_use) {
  Image image(width, height);
  const uint8_t* p = bytes.data();
  for (int y = 0; y < height; ++y) {
    Rgba* row = image.Row(y);
    for (int x = 0; x < width; ++x, p += 4) {
      const Rgba plain = {p[0], p[1], p[2], p[3]};
      row[x] = alpha_use == AlphaUse::kPremultiplied ? Premultiplied(plain)
                                                     : Rgba{p[0], p[1], p[2], 255};
    }
  }
  return image;
}

}  // namespace

absl::StatusOr<Image> DecodePng(absl::string_view bytes, AlphaUse alpha_use) {
  Source source = {bytes};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, OnError, OnWarning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr) {
    png_destroy_read_struct(&png, nullptr, nullptr);
    return absl::ResourceExhaustedError("no memory to decode a PNG");
  }
  png_set_read_fn(png, &source, ReadBytes);
  std::vector<uint8_t> pixels;
  std::vector<png_bytep> rows;
  int width = 0;
  int height = 0;
  const bool read = ReadImage(png, info, &pixels, &rows, &width, &height);
  png_destroy_read_struct(&png, &info, nullptr);
  if (!read) {
    return absl::InvalidArgumentError(absl::StrCat("is not a valid PNG: ", source.message));
  }
  return ToImage(pixels, width, height, alpha_use);
}

absl::StatusOr<PngSize> CheckPng(absl::string_view bytes) {
  constexpr size_t kSignatureBytes = 8;
  if (bytes.size() < kSignatureBytes || png_sig_cmp(Unsigned(bytes), 0, kSignatureBytes) != 0) {
    return absl::InvalidArgumentError("is not a PNG file");
  }
  absl::string_view rest = bytes.substr(kSignatureBytes);
  Chunk chunk;
  if (!TakeChunk(&rest, &chunk) || chunk.type != "IHDR" || chunk.content.size() != 13) {
    return absl::InvalidArgumentError("is not a valid PNG: the header is damaged");
  }
  const uint32_t width = BigEndian(chunk.content);
  const uint32_t height = BigEndian(chunk.content.substr(4));
  if (width < 1 || width > kPngSizePxMax || height < 1 || height > kPngSizePxMax) {
    return absl::InvalidArgumentError(absl::StrCat(
        "is ", width, " x ", height, " pixels, each side must be in [1, ", kPngSizePxMax, "]"));
  }
  while (chunk.type != "IEND") {
    if (!TakeChunk(&rest, &chunk)) {
      return absl::InvalidArgumentError("is not a valid PNG: damaged or truncated");
    }
  }
  return PngSize{static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace procgen
