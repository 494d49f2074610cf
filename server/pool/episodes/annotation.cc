#include "server/pool/episodes/annotation.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"

namespace procgen {
namespace {

bool IsNameCharacter(char character) {
  constexpr absl::string_view kOthers = "_-./ ";
  return absl::ascii_isalnum(static_cast<unsigned char>(character)) ||
         kOthers.find(character) != absl::string_view::npos;
}

absl::Status CheckName(absl::Span<const Annotation> annotations, size_t i) {
  const absl::string_view name = annotations[i].name;
  if (name.empty() || name.size() > kAnnotationNameBytesMax ||
      !std::all_of(name.begin(), name.end(), IsNameCharacter)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "annotations[", i, "].name is '", absl::CHexEscape(name.substr(0, kAnnotationNameBytesMax)),
        "' of ", name.size(), " bytes, allowed: 1 to ", kAnnotationNameBytesMax,
        " letters, digits, spaces and _ - . /"));
  }
  const absl::Span<const Annotation> before = annotations.subspan(0, i);
  if (std::any_of(before.begin(), before.end(),
                  [name](const Annotation& other) { return other.name == name; })) {
    return absl::InvalidArgumentError(absl::StrCat("annotations[", i, "].name is '", name,
                                                   "' again, allowed: each name at most once"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckAnnotations(absl::Span<const Annotation> annotations, int32_t env_count) {
  if (annotations.size() > kAnnotationCountMax) {
    return absl::InvalidArgumentError(absl::StrCat("annotations has ", annotations.size(),
                                                   " entries, allowed: at most ",
                                                   kAnnotationCountMax));
  }
  const auto rows = static_cast<size_t>(env_count);
  for (size_t i = 0; i < annotations.size(); ++i) {
    if (absl::Status status = CheckName(annotations, i); !status.ok()) {
      return status;
    }
    const size_t count = annotations[i].values.size();
    const size_t values_max =
        annotations[i].name == kSaliencyName ? kSaliencyValuesMax : kAnnotationValuesMax;
    if (count == 0 || count % rows != 0 || count / rows > values_max) {
      return absl::InvalidArgumentError(absl::StrCat(
          "annotations[", i, "] '", annotations[i].name, "' has ", count, " values, allowed: 1 to ",
          values_max, " for each of the ", env_count, " environments of the slice"));
    }
  }
  return absl::OkStatus();
}

void CopyAnnotations(absl::Span<const Annotation> annotations, int32_t env_count, size_t row,
                     std::vector<EnvironmentAnnotation>* copies) {
  copies->resize(annotations.size());
  for (size_t i = 0; i < annotations.size(); ++i) {
    const absl::Span<const float> all = annotations[i].values;
    const size_t count = all.size() / static_cast<size_t>(env_count);
    const absl::Span<const float> values = all.subspan(row * count, count);
    (*copies)[i].name.assign(annotations[i].name.data(), annotations[i].name.size());
    (*copies)[i].values.assign(values.begin(), values.end());
  }
}

}  // namespace procgen
