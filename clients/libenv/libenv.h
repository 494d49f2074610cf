// libenv: the C interface, version 1, that the Procgen ecosystem's Python package loads
// environments through. Written from the facts of its binary layout on 64-bit Linux; C99 and C++
// can include it.
//
// Life: libenv_make, libenv_get_tensortypes (as often as wanted), libenv_set_buffers once, then
// libenv_observe and libenv_act in turn, libenv_close.
// Threads: different handles may be used from different threads at the same time; one handle by one
// thread at a time.
// Errors: no function ends the process or lets an exception out. What goes wrong is told in one
// line on standard error; clients/libenv/README.md, "When something is wrong".
#ifndef CLIENTS_LIBENV_LIBENV_H_
#define CLIENTS_LIBENV_LIBENV_H_

#include <stdint.h>  // NOLINT(modernize-deprecated-headers): C includes this file, too

#define LIBENV_API __attribute__((visibility("default")))

// The size of a name, its closing zero included, and the most dimensions of a tensor.
enum { kLibenvNameBytes = 128, kLibenvDimensionCountMax = 16 };

#ifdef __cplusplus
extern "C" {
#endif

// The environments that libenv_make made.
struct LibenvHandle;

// The numbers of the three enums are part of the interface: never renumber them. Where one is
// stored or passed it is an int, as a caller may be wrong.
enum LibenvValueType {
  kLibenvValueTypeUnused = 0,
  kLibenvUint8 = 1,
  kLibenvInt32 = 2,
  kLibenvFloat32 = 3,
};

enum LibenvScalarType {
  kLibenvScalarTypeUnused = 0,
  kLibenvReal = 1,
  kLibenvDiscrete = 2,
};

enum LibenvSpace {
  kLibenvSpaceUnused = 0,
  kLibenvObservation = 1,
  kLibenvAction = 2,
  kLibenvInfo = 3,
};

// One value of a tensor; which member counts is told by its value type.
union LibenvValue {
  uint8_t uint8;
  int32_t int32;
  float float32;
};

// What one member of a space is.
struct LibenvTensorType {
  char name[kLibenvNameBytes];          // zero-terminated
  int scalar_type;                      // a LibenvScalarType
  int value_type;                       // a LibenvValueType
  int shape[kLibenvDimensionCountMax];  // the first dimension_count count
  int dimension_count;                  // 0: a single value
  union LibenvValue low;                // the least value
  union LibenvValue high;               // the greatest value, included
};

// One option. A string: uint8, `count` its length, not zero-terminated. A boolean: uint8, count 1,
// 0 or 1. An integer: int32, count 1.
struct LibenvOption {
  char name[kLibenvNameBytes];  // zero-terminated
  int value_type;               // a LibenvValueType
  int count;
  void* data;
};

struct LibenvOptions {
  struct LibenvOption* items;  // [count]
  int count;
};

// The caller's memory, for N environments. A pointer array of a space with M members has M x N
// entries: entry `member * N + environment` points to that environment's value.
struct LibenvBuffers {
  void** observations;  // [1 * N] to uint8 [64, 64, 3], top row first, red, green, blue
  float* rewards;       // [N]
  uint8_t* firsts;      // [N] 1: the observation is the first of an episode
  void** infos;         // [3 * N], with render_human [4 * N]
  void** actions;       // [1 * N] to int32
};

// The version of the interface: 1.
LIBENV_API int libenv_version(void);

// Makes `env_count` environments. `options` is only looked at during the call. Null: an
// option is unknown, malformed, out of range or missing, or the server cannot be had.
LIBENV_API struct LibenvHandle* libenv_make(int env_count, struct LibenvOptions options);

// Returns how many members a space (a LibenvSpace) has and, where `types` is not null, tells them.
// 0: no such space, or `handle` is null.
LIBENV_API int libenv_get_tensortypes(struct LibenvHandle* handle, int space,
                                      struct LibenvTensorType* types);

// Tells where values are to be written and actions are to be read. The pointer arrays are only
// looked at during the call; what their entries, `rewards` and `firsts` point to must stay until
// libenv_close.
LIBENV_API void libenv_set_buffers(struct LibenvHandle* handle, struct LibenvBuffers* buffers);

// Waits for the step and writes all buffers but the actions. Again without a step between: the same
// again.
LIBENV_API void libenv_observe(struct LibenvHandle* handle);

// Takes the actions, each in [-1, 14], and begins the step; -1 does nothing and ends the episode.
LIBENV_API void libenv_act(struct LibenvHandle* handle);

// Waits for the step and frees everything. Null is no error.
LIBENV_API void libenv_close(struct LibenvHandle* handle);

// Waits for the step, writes a snapshot of one environment to `data`, and returns its size. 0: it
// could not be taken, or `length` bytes are too few (it has at most 1 MiB); nothing is written
// then.
LIBENV_API int get_state(struct LibenvHandle* handle, int environment, char* data, int length);

// Waits for the step, puts one environment into the state of a snapshot and refreshes its buffers.
// The snapshot's options (the distribution mode, say) become the environment's. Of a snapshot that
// is no good, or of another game, nothing is taken.
LIBENV_API void set_state(struct LibenvHandle* handle, int environment, char* data, int length);

#ifdef __cplusplus
}
#endif

#endif  // CLIENTS_LIBENV_LIBENV_H_
