#ifndef SERVER_RPC_CONVERT_OBSERVATION_H_
#define SERVER_RPC_CONVERT_OBSERVATION_H_

#include <optional>

#include "absl/status/statusor.h"
#include "envcore/pool/pool.h"
#include "procgen/v1/pools.pb.h"
#include "server/encoding/compressor.h"

namespace procgen {

// Errors: INVALID_ARGUMENT a value that its field does not offer.
absl::StatusOr<ObservationFormat> ObservationFormatOf(const v1::ObservationFormat& message);
// Every default filled in.
void FillObservationFormat(const ObservationFormat& format, v1::ObservationFormat* message);

// What the encoding that a spec asks for compresses with; none: observations are sent as they are
// drawn. Errors: INVALID_ARGUMENT no such encoding, or one that does not go with the transport.
absl::StatusOr<std::optional<Compression>> CompressionOf(const v1::PoolSpec& spec);
v1::Encoding EncodingMessageOf(std::optional<Compression> compression);

}  // namespace procgen

#endif  // SERVER_RPC_CONVERT_OBSERVATION_H_
