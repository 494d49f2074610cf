#ifndef SERVER_FLEET_POOL_ANSWER_ROWS_H_
#define SERVER_FLEET_POOL_ANSWER_ROWS_H_

#include <cstddef>

#include "envcore/pool/pool.h"
#include "procgen_client/batch.h"

namespace procgen {

// Copies `row_count` rows of a node's answer, from `answer_row`, into a batch, from `batch_row`.
// Arrays that only one of them has are left unchanged. `observation_bytes`: of one environment.
void CopyAnswerRows(const procgen_client::Batch& answer, size_t answer_row, const Batch& batch,
                    size_t batch_row, size_t row_count, size_t observation_bytes);

}  // namespace procgen

#endif  // SERVER_FLEET_POOL_ANSWER_ROWS_H_
