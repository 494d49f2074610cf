// libenv: the C interface, version 1, through which the Procgen ecosystem's Python packages load
// environments. Written from the facts of its binary layout on 64-bit Linux. For C99 and C++.
//
// Order of calls: libenv_make, libenv_get_tensortypes (any number of times), libenv_set_buffers
// once, then libenv_observe and libenv_act in turn, libenv_close.
// Threads: different handles may be used from different threads at the same time; one handle by one
// thread at a time.
// Errors: no function ends the process or throws. A failure is one line on standard error; see
// clients/libenv/README.md, "Errors".
#ifndef CLIENTS_LIBENV_LIBENV_H_
#define CLIENTS_LIBENV_LIBENV_H_

#include <stdint.h>  // NOLINT(modernize-deprecated-headers): C includes this file, too

#define LIBENV_API __attribute__((visibility("default")))

// Bytes of a name including its terminating zero, and maximum number of dimensions of a tensor.
enum { kLibenvNameBytes = 128, kLibenvDimensionCountMax = 16 };

#ifdef __cplusplus
extern "C" {
#endif

// Environments created by libenv_make. Opaque.
struct LibenvHandle;

// The values of the three enums are part of the interface: never renumber them. They are stored and
// passed as int, because a caller may pass other values.
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

// One value of a tensor; its value type selects the member.
union LibenvValue {
  uint8_t uint8;
  int32_t int32;
  float float32;
};

// Type of one member of a space.
struct LibenvTensorType {
  char name[kLibenvNameBytes];          // zero-terminated
  int scalar_type;                      // a LibenvScalarType
  int value_type;                       // a LibenvValueType
  int shape[kLibenvDimensionCountMax];  // the first dimension_count are used
  int dimension_count;                  // 0: a single value
  union LibenvValue low;                // smallest value
  union LibenvValue high;               // largest value, inclusive
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

// Returns the version of the interface, 1.
LIBENV_API int libenv_version(void);

// Creates `env_count` environments, 1 to 65536. `options` is not used after the call. Returns null
// if an option is unknown, malformed, out of range or missing.
LIBENV_API struct LibenvHandle* libenv_make(int env_count, struct LibenvOptions options);

// Returns the number of members of a space (a LibenvSpace) and, if `types` is not null, stores
// their types there. 0: no such space, or `handle` is null.
LIBENV_API int libenv_get_tensortypes(struct LibenvHandle* handle, int space,
                                      struct LibenvTensorType* types);

// Sets the buffers for values and actions. The pointer arrays are not used after the call; the
// memory that their entries, `rewards` and `firsts` point to must stay valid until libenv_close.
LIBENV_API void libenv_set_buffers(struct LibenvHandle* handle, struct LibenvBuffers* buffers);

// Waits for the step and writes all buffers except the actions. Without a step in between, it
// writes the same values again.
LIBENV_API void libenv_observe(struct LibenvHandle* handle);

// Reads the actions, each in [-1, 14], and starts a step; -1 does nothing and ends the episode.
LIBENV_API void libenv_act(struct LibenvHandle* handle);

// Waits for the step and frees all resources. Null is ignored.
LIBENV_API void libenv_close(struct LibenvHandle* handle);

// Waits for the step, writes a snapshot of one environment to `data`, and returns its size in
// bytes, at most 1 MiB. On failure, also if it needs more than `length` bytes, it writes nothing
// and returns 0.
LIBENV_API int get_state(struct LibenvHandle* handle, int environment, char* data, int length);

// Waits for the step, restores a snapshot in one environment and refreshes its buffers. The
// environment takes the snapshot's options, e.g. the distribution mode. A snapshot that is damaged
// or of another game changes nothing.
LIBENV_API void set_state(struct LibenvHandle* handle, int environment, char* data, int length);

#ifdef __cplusplus
}
#endif

#endif  // CLIENTS_LIBENV_LIBENV_H_
