#ifndef PROCGEN_CLIENT_RUN_STEP_PART_H_
#define PROCGEN_CLIENT_RUN_STEP_PART_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "envcore/pool/pool.h"
#include "procgen_client/pool.h"

namespace procgen_client {

// Rows [begin, begin + count) of a request and of the batch that it is answered with. `whole` and
// what it refers to must outlive it.
struct StepPart {
  StepPart(const procgen::StepInput& whole, absl::Span<const Annotation> whole_annotations,
           const procgen::Batch& whole_batch, int32_t begin, int32_t count,
           size_t observation_bytes);
  // Makes environment `first` of the pool environment 0.
  void RenumberFrom(int32_t first);
  StepPart(const StepPart&) = delete;
  StepPart& operator=(const StepPart&) = delete;

  std::vector<procgen::NextLevel> next_levels;
  std::vector<procgen::Reset> resets;
  std::vector<Annotation> annotations;
  procgen::StepInput input;  // refers to the members above
  procgen::Batch batch;
};

}  // namespace procgen_client

#endif  // PROCGEN_CLIENT_RUN_STEP_PART_H_
