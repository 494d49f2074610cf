#include "envcore/state/snapshot_frame.h"

#include "absl/strings/str_cat.h"
#include "envcore/status/status.h"
#include "zlib.h"

namespace procgen {
namespace {

constexpr size_t kVersionOffset = 4;
constexpr size_t kLengthOffset = 8;
constexpr size_t kChecksumOffset = 12;

uint32_t ChecksumOf(absl::string_view body) {
  return static_cast<uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size())));
}

void AppendNumber(uint32_t value, std::string* bytes) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes->push_back(static_cast<char>((value >> shift) & 0xFFU));
  }
}

uint32_t NumberAt(absl::string_view bytes, size_t offset) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) {
    value |= static_cast<uint32_t>(static_cast<uint8_t>(bytes[offset + i])) << (8 * i);
  }
  return value;
}

}  // namespace

std::string FrameSnapshot(absl::string_view body) {
  std::string bytes(kSnapshotMagic);
  bytes.reserve(kSnapshotHeaderBytes + body.size());
  AppendNumber(kSnapshotVersion, &bytes);
  AppendNumber(static_cast<uint32_t>(body.size()), &bytes);
  AppendNumber(ChecksumOf(body), &bytes);
  bytes.append(body.data(), body.size());
  return bytes;
}

uint32_t SnapshotChecksum(absl::string_view snapshot) {
  return NumberAt(snapshot, kChecksumOffset);
}

StatusOr<absl::string_view> UnframeSnapshot(absl::string_view snapshot) {
  if (snapshot.size() < kSnapshotHeaderBytes) {
    return DataLossError(absl::StrCat("the snapshot has ", snapshot.size(),
                                      " bytes, must have at least ", kSnapshotHeaderBytes));
  }
  if (snapshot.size() > kSnapshotBytesMax) {
    return DataLossError(absl::StrCat("the snapshot has ", snapshot.size(),
                                      " bytes, must have at most ", kSnapshotBytesMax));
  }
  if (snapshot.substr(0, kSnapshotMagic.size()) != kSnapshotMagic) {
    return DataLossError("the bytes are not a snapshot: they do not begin with \"PGST\"");
  }
  const uint32_t version = NumberAt(snapshot, kVersionOffset);
  if (version != kSnapshotVersion) {
    return DataLossError(absl::StrCat("the snapshot is of version ", version,
                                      ", this engine supports version ", kSnapshotVersion));
  }
  const absl::string_view body = snapshot.substr(kSnapshotHeaderBytes);
  const uint32_t length = NumberAt(snapshot, kLengthOffset);
  if (length != body.size()) {
    return DataLossError(
        absl::StrCat("the snapshot's body has ", body.size(), " bytes, its header says ", length));
  }
  if (NumberAt(snapshot, kChecksumOffset) != ChecksumOf(body)) {
    return DataLossError("the snapshot's checksum does not match its body");
  }
  return body;
}

}  // namespace procgen
