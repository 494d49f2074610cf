#include "server/pool/session_options.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace procgen {
namespace {

bool IsKeyCharacter(char character) {
  constexpr absl::string_view kOthers = "_-./";
  return absl::ascii_isalnum(static_cast<unsigned char>(character)) ||
         kOthers.find(character) != absl::string_view::npos;
}

// Whether UTF-8 text contains a control character: U+0000 to U+001F, U+007F to U+009F.
bool HasControlCharacter(absl::string_view text) {
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (absl::ascii_iscntrl(byte)) {
      return true;
    }
    constexpr unsigned char kC1Lead = 0xC2;
    constexpr unsigned char kC1Last = 0x9F;
    if (byte == kC1Lead && i + 1 < text.size() &&
        static_cast<unsigned char>(text[i + 1]) <= kC1Last) {
      return true;
    }
  }
  return false;
}

absl::Status CheckText(absl::string_view field, absl::string_view text, size_t bytes_max) {
  if (text.size() > bytes_max || HasControlCharacter(text)) {
    return absl::InvalidArgumentError(absl::StrCat(
        field, " is '", absl::CHexEscape(text.substr(0, bytes_max)), "' of ", text.size(),
        " bytes, allowed: at most ", bytes_max, " bytes of UTF-8 without control characters"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckSessionOptions(const SessionOptions& options) {
  if (absl::Status status =
          CheckText("spec.display_name", options.display_name, kDisplayNameBytesMax);
      !status.ok()) {
    return status;
  }
  if (options.labels.size() > kLabelCountMax) {
    return absl::InvalidArgumentError(absl::StrCat("spec.labels has ", options.labels.size(),
                                                   " entries, allowed: at most ", kLabelCountMax));
  }
  for (const auto& [key, value] : options.labels) {
    if (key.empty() || key.size() > kLabelKeyBytesMax ||
        !std::all_of(key.begin(), key.end(), IsKeyCharacter)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "spec.labels has the key '", absl::CHexEscape(key.substr(0, kLabelKeyBytesMax)), "' of ",
          key.size(), " bytes, allowed: 1 to ", kLabelKeyBytesMax, " letters, digits and _ - . /"));
    }
    if (absl::Status status =
            CheckText(absl::StrCat("spec.labels['", key, "']"), value, kLabelValueBytesMax);
        !status.ok()) {
      return status;
    }
  }
  return absl::OkStatus();
}

}  // namespace procgen
