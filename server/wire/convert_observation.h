#ifndef SERVER_WIRE_CONVERT_OBSERVATION_H_
#define SERVER_WIRE_CONVERT_OBSERVATION_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "envcore/pool/pool.h"
#include "procgen/v1/pools.pb.h"
#include "server/encoding/encoding.h"

namespace procgen {

// Errors: INVALID_ARGUMENT a value is not allowed for its field.
absl::StatusOr<ObservationFormat> ObservationFormatOf(const v1::ObservationFormat& message);
// Sets every field, including defaults.
void FillObservationFormat(const ObservationFormat& format, v1::ObservationFormat* message);

// Errors: INVALID_ARGUMENT unknown encoding.
absl::StatusOr<Encoding> EncodingOf(absl::string_view field, v1::Encoding encoding);
v1::Encoding EncodingMessageOf(Encoding encoding);

}  // namespace procgen

#endif  // SERVER_WIRE_CONVERT_OBSERVATION_H_
