#ifndef SERVER_ENCODING_DELTA_H_
#define SERVER_ENCODING_DELTA_H_

#include <cstdint>

#include "server/encoding/byte_list.h"
#include "server/encoding/motion_search.h"
#include "server/encoding/picture_shape.h"

namespace procgen {

// The delta of observations to previous ones: one list per kind of value, since values of one kind
// compress best together. `Encoding` in pools.proto defines them.
struct Delta {
  ByteList changed;       // a bit for each block of each observation
  ByteList move_rows;     // of each changed block: int8
  ByteList move_columns;  // of each changed block: int8
  ByteList patched;       // of each changed block: a bit for each row
  ByteList masks;         // of each patched row: a bit for each pixel
  ByteList pixels;        // each patched pixel

  void Clear();
};

// Appends the delta from `before` to `now`, each shape.bytes() long, to `delta`. `search`: the
// motion state of this environment.
void AppendDelta(const PictureShape& shape, const uint8_t* before, const uint8_t* now,
                 MotionSearch& search, Delta& delta);

}  // namespace procgen

#endif  // SERVER_ENCODING_DELTA_H_
