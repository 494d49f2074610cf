// libprocgen: Procgen environments in the calling process, behind a C ABI.
//
//   ProcgenPoolOptions options;
//   procgen_pool_options_init(&options, sizeof(options));
//   const char* games[] = {"coinrun"};
//   options.games = games;
//   options.game_count = 1;
//   options.env_count = 64;
//   ProcgenPool* pool;
//   if (procgen_pool_create(&options, &pool) != PROCGEN_OK) { puts(procgen_error_message()); }
//
// Shapes: N environments in a pool, n in a slice, F one observation (ProcgenPoolInfo); arrays are
// row-major, environment first, without gaps, and belong to the caller.
// Errors: a function that can fail returns a ProcgenCode. procgen_error_message() then says what
// was given and what is allowed. A failed call has changed nothing, unless its comment says
// otherwise. Threads: functions without a pool from any thread. One pool from one thread at a time;
// one in this process may also be sent to by one thread while another receives.
// Different pools do not wait for each other. Fork: a pool belongs to the process that created it.
// In a forked child every call on it fails with PROCGEN_FAILED_PRECONDITION, and
// procgen_pool_destroy frees nothing; new pools work.
// Versions: structs begin with their size, so a program and a library of different versions agree
// on the fields that both have.
#ifndef CLIENTS_C_PROCGEN_H_
#define CLIENTS_C_PROCGEN_H_

// C includes this file, too. NOLINTBEGIN(modernize-*,readability-identifier-naming)
#include <stddef.h>
#include <stdint.h>

#define PROCGEN_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

// Version of this interface. A library with another one is not compatible.
#define PROCGEN_ABI_VERSION 1

// Actions are in [0, PROCGEN_ACTION_COUNT). -1 does nothing and ends the episode.
#define PROCGEN_ACTION_COUNT 15

// A pool of environments that are stepped together. Opaque.
typedef struct ProcgenPool ProcgenPool;

// gRPC's canonical codes. Never renumber them. Those marked * only libprocgen_remote returns
// (procgen_remote.h).
typedef enum ProcgenCode {
  PROCGEN_OK = 0,
  PROCGEN_CANCELLED = 1,            // * the caller or the connection's end cancelled a wait
  PROCGEN_UNKNOWN = 2,              // *
  PROCGEN_INVALID_ARGUMENT = 3,     // a value out of range
  PROCGEN_DEADLINE_EXCEEDED = 4,    // procgen_receive: not done yet
  PROCGEN_NOT_FOUND = 5,            // no such game, no such folder of art
  PROCGEN_ALREADY_EXISTS = 6,       // * a pool of this name
  PROCGEN_PERMISSION_DENIED = 7,    // *
  PROCGEN_RESOURCE_EXHAUSTED = 8,   // a named limit, or too little room
  PROCGEN_FAILED_PRECONDITION = 9,  // not in this state of the pool
  PROCGEN_ABORTED = 10,             // another thread uses the pool
  PROCGEN_OUT_OF_RANGE = 11,        // *
  PROCGEN_UNIMPLEMENTED = 12,       // * the server does not offer it
  PROCGEN_INTERNAL = 13,            // a bug of the library, or of the server
  PROCGEN_UNAVAILABLE = 14,         // * no server answers, or it drains
  PROCGEN_DATA_LOSS = 15,           // a snapshot is damaged or of another version
  PROCGEN_UNAUTHENTICATED = 16,     // * no valid token or certificate
} ProcgenCode;

typedef enum ProcgenDistributionMode {
  PROCGEN_EASY = 0,
  PROCGEN_HARD = 1,
  PROCGEN_EXTREME = 2,
  PROCGEN_MEMORY = 10,
  PROCGEN_EXPLORATION = 20,
} ProcgenDistributionMode;

// What follows the step that ends an episode.
typedef enum ProcgenAutoresetMode {
  PROCGEN_SAME_STEP = 0,  // that step returns the first observation of the next episode
  PROCGEN_NEXT_STEP = 1,  // the next step ignores its action and begins the next episode
  PROCGEN_DISABLED = 2,   // stepping again without a reset is an error
} ProcgenAutoresetMode;

typedef enum ProcgenLayout {
  PROCGEN_HWC = 0,  // [side, side, channels]
  PROCGEN_CHW = 1,  // [channels, side, side]
} ProcgenLayout;

// Draws levels from a weighted list of seeds.
typedef struct ProcgenLevelSampler {
  size_t struct_size;
  const int32_t* level_seeds;  // [seed_count], any values, duplicates allowed
  const float* weights;        // [seed_count], relative, finite, >= 0; null: uniform
  int64_t seed_count;          // in [1, 1000000]
  int64_t rand_seed;           // modulo 2^32
} ProcgenLevelSampler;

// What procgen_pool_create makes. procgen_pool_options_init sets the defaults given here.
typedef struct ProcgenPoolOptions {
  size_t struct_size;
  const char* const* games;  // [game_count] names; environment i plays games[i % game_count]
  int32_t game_count;        // in [1, 64]; env_count (or total_env_count) is a multiple of it
  int32_t env_count;         // N, at least 1
  // A slice of a larger set of environments: environment i plays the episodes of environment
  // first_env + i of total_env_count.
  int32_t first_env;        // 0
  int32_t total_env_count;  // 0: first_env + env_count

  // The options of Procgen 0.10.7, with the defaults of its Python package.
  int32_t distribution_mode;      // a ProcgenDistributionMode; PROCGEN_HARD
  int32_t num_levels;             // number of different levels; 0: unlimited
  int32_t start_level;            // first level seed; unused if num_levels is 0
  int32_t debug_mode;             // bit mask that coinrun reads; 0
  int64_t rand_seed;              // seeds the choice of levels, modulo 2^32
  uint8_t has_rand_seed;          // 0: rand_seed is drawn, see ProcgenPoolInfo
  uint8_t use_sequential_levels;  // 0
  uint8_t center_agent;           // 1
  uint8_t use_backgrounds;        // 1
  uint8_t use_generated_assets;   // 0
  uint8_t use_monochrome_assets;  // 0
  uint8_t restrict_themes;        // 0
  uint8_t paint_vel_info;         // 0

  int32_t autoreset_mode;  // a ProcgenAutoresetMode; PROCGEN_SAME_STEP
  int32_t screen_size;     // side of an observation in pixels, in [16, 512]; 64
  int32_t frame_stack;     // frames in an observation, in [1, 16], oldest first; 1
  int32_t layout;          // a ProcgenLayout; PROCGEN_HWC
  uint8_t grayscale_obs;   // 1: one channel; 0

  const ProcgenLevelSampler* level_sampler;  // chooses the levels; null: num_levels, start_level do
  const char* art;                           // folder of upstream's images; null: the built-in art
  int32_t num_threads;  // threads that step beside the caller, in [0, 1024]; -1: one a further core
  // A variant of the games, which procgen_catalog_json lists: levels differ from upstream's by one
  // change, such as the place of the coin, or another value of a constant, "gravity=0.1". Null or
  // "": upstream's.
  const char* variant;
} ProcgenPoolOptions;

typedef struct ProcgenPoolInfo {
  size_t struct_size;
  int32_t env_count;  // N
  int32_t num_threads;
  int64_t rand_seed;             // given, or drawn
  int32_t observation_rank;      // length of observation_shape, 3 or 4
  int32_t observation_shape[4];  // F, e.g. 64, 64, 3; frame_stack k > 1 before these
  int64_t observation_bytes;     // product of the shape
} ProcgenPoolInfo;

// An object of an environment, as ten numbers. Unused rows have kind -1 and else zeros.
typedef struct ProcgenObject {
  float kind;   // number of a kind of the game; procgen_catalog_json has the names
  float theme;  // index of its image, such as the color of a key
  float x;      // center, in cells from the bottom left of the level
  float y;
  float vx;  // cells per step
  float vy;
  float rx;  // half-sizes, in cells
  float ry;
  float rotation;  // radians, clockwise on the screen
  float health;    // as the game defines it; 1: unused
} ProcgenObject;

// An environment that starts a new episode in place of a step.
typedef struct ProcgenReset {
  int32_t environment;     // index in the pool
  int32_t level_seed;      // level to play
  int64_t rand_seed;       // reseeds the choice of levels, modulo 2^32
  uint8_t has_level_seed;  // 0: the level is chosen as after any episode
  uint8_t has_rand_seed;   // 0: not reseeded
} ProcgenReset;

// The level of an environment's next episode, in place of a drawn one. It stays set until it is
// played or another is given.
typedef struct ProcgenNextLevel {
  int32_t environment;  // index in the pool
  int32_t level_seed;
} ProcgenNextLevel;

// Values of one kind for viewers of a step, such as value estimates.
typedef struct ProcgenAnnotation {
  const char* name;     // 1 to 64 bytes: letters, digits, spaces and _ - . /
  const float* values;  // [n, value_count], environment first
  int32_t value_count;  // for each environment, in [1, 64]; of "saliency" in [1, 4096]
} ProcgenAnnotation;

// A step of the environments [first_env, first_env + env_count). Everything is copied by the call.
typedef struct ProcgenStep {
  size_t struct_size;
  int32_t first_env;
  int32_t env_count;       // n, at least 1
  const int32_t* actions;  // [n], each in [-1, 15)
  int32_t repeat_count;    // in [1, 1000]; 0: 1. Rewards are summed; an environment
                           // stops when its level ends
  int32_t next_level_count;
  const ProcgenNextLevel* next_levels;  // [next_level_count], each environment at most once
  const ProcgenReset* resets;           // [reset_count], each environment at most once
  int32_t reset_count;
  // [annotation_count], at most 16, each name at most once. A pool in this process has no viewers
  // and ignores them.
  const ProcgenAnnotation* annotations;
  int32_t annotation_count;
} ProcgenStep;

// Memory for the values of n environments. A null array is not written. Without `observations`
// nothing is drawn, which is many times faster (with a frame stack, frames are drawn all the same).
//
// Before the first step `first` is 1 and the other flags and numbers are 0. So it is in rows that
// were reset; prev_level_seeds is the level that was left there.
typedef struct ProcgenBatch {
  size_t struct_size;
  uint8_t* observations;         // after any new level                               [n, F]
  float* rewards;                // of this step, summed over repetitions             [n]
  uint8_t* first;                // 1: a new episode has begun                        [n]
  uint8_t* terminated;           // 1: the game (or action -1) ended the episode      [n]
  uint8_t* truncated;            // 1: the time limit ended it                        [n]
  int32_t* level_seeds;          // of the level in the observation                   [n]
  int32_t* prev_level_seeds;     // of the level that was stepped, or left by a reset [n]
  uint8_t* prev_level_complete;  // 1: this step completed it                         [n]
  float* episode_returns;        // of the episode that ended, or of the current one  [n]
  int32_t* episode_lengths;      // steps of the same episode                         [n]
  uint64_t* fingerprints;        // of each episode that ended: equal for equal ones;
                                 // 0 in other rows                                   [n]
  uint8_t* final_observations;   // last observation of each episode that ended; other rows are not
                                 // written. With PROCGEN_SAME_STEP                   [n, F]
} ProcgenBatch;

// PROCGEN_ABI_VERSION of the library.
PROCGEN_API int32_t procgen_abi_version(void);
// Version of the package, e.g. "0.9.0".
PROCGEN_API const char* procgen_version(void);
// What the last failed call of this thread was given and what is allowed. Valid until its next
// call.
PROCGEN_API const char* procgen_error_message(void);
// The games as JSON: names, descriptions, modes with time limits and return ranges, actions with
// their keys, what special actions do. Valid for the life of the process.
PROCGEN_API const char* procgen_catalog_json(void);

// Sets the defaults. `struct_size`: sizeof(ProcgenPoolOptions).
PROCGEN_API void procgen_pool_options_init(ProcgenPoolOptions* options, size_t struct_size);

// Makes a pool; every environment is at the first step of its first level. `options` is not used
// after the call. Errors: INVALID_ARGUMENT, NOT_FOUND.
PROCGEN_API ProcgenCode procgen_pool_create(const ProcgenPoolOptions* options, ProcgenPool** pool);
// Frees a pool. Unanswered requests end first. Null is ignored.
PROCGEN_API void procgen_pool_destroy(ProcgenPool* pool);
PROCGEN_API ProcgenCode procgen_pool_info(const ProcgenPool* pool, ProcgenPoolInfo* info);

// Steps a slice and waits for its values. Errors: INVALID_ARGUMENT; FAILED_PRECONDITION an
// environment's episode has ended and it is not reset (PROCGEN_DISABLED), or a request is
// unanswered.
PROCGEN_API ProcgenCode procgen_step(ProcgenPool* pool, const ProcgenStep* step,
                                     const ProcgenBatch* batch);
// Starts new episodes in some environments of a slice, and writes the values of the whole slice.
// `resets`: [reset_count], at least one, each environment at most once. Errors: as procgen_step.
PROCGEN_API ProcgenCode procgen_reset(ProcgenPool* pool, int32_t first_env, int32_t env_count,
                                      const ProcgenReset* resets, int32_t reset_count,
                                      const ProcgenBatch* batch);
// Writes the current values of a slice again. Errors: as procgen_step.
PROCGEN_API ProcgenCode procgen_observe(ProcgenPool* pool, int32_t first_env, int32_t env_count,
                                        const ProcgenBatch* batch);

// The same without waiting: the pool's threads work meanwhile. Several requests may be unanswered;
// they are executed and answered in order. The arrays of `batch` must stay valid until
// procgen_receive has answered the request. Errors that depend on the pool's state come with
// procgen_receive.
PROCGEN_API ProcgenCode procgen_send_step(ProcgenPool* pool, const ProcgenStep* step,
                                          const ProcgenBatch* batch);
PROCGEN_API ProcgenCode procgen_send_reset(ProcgenPool* pool, int32_t first_env, int32_t env_count,
                                           const ProcgenReset* resets, int32_t reset_count,
                                           const ProcgenBatch* batch);
PROCGEN_API ProcgenCode procgen_send_observe(ProcgenPool* pool, int32_t first_env,
                                             int32_t env_count, const ProcgenBatch* batch);
// Waits for the oldest unanswered request, and returns its result. `timeout_s`: seconds; negative:
// no limit. Errors: DEADLINE_EXCEEDED not done yet, call again; FAILED_PRECONDITION nothing is
// unanswered; those of the request.
PROCGEN_API ProcgenCode procgen_receive(ProcgenPool* pool, double timeout_s);
// Number of unanswered requests.
PROCGEN_API int32_t procgen_unanswered_count(const ProcgenPool* pool);

// Replaces the level sampler, from each environment's next choice of a level. Errors:
// INVALID_ARGUMENT.
PROCGEN_API ProcgenCode procgen_set_level_sampler(ProcgenPool* pool,
                                                  const ProcgenLevelSampler* sampler);

// Saves environments. `offsets`: [count + 1]; snapshot i is data[offsets[i]] to
// data[offsets[i + 1]]. Errors: INVALID_ARGUMENT; RESOURCE_EXHAUSTED `capacity` is less than
// offsets[count], which is set.
PROCGEN_API ProcgenCode procgen_save_states(ProcgenPool* pool, const int32_t* environments,
                                            int32_t count, uint8_t* data, size_t capacity,
                                            size_t* offsets);
// Restores environments from snapshots, which may come from any pool of the same game. All or
// nothing. Errors: INVALID_ARGUMENT; FAILED_PRECONDITION another game's snapshot; DATA_LOSS.
PROCGEN_API ProcgenCode procgen_restore_states(ProcgenPool* pool, const int32_t* environments,
                                               int32_t count, const uint8_t* data,
                                               const size_t* offsets);
// Copies states within the pool. All sources are read before a target is written. All or nothing.
// Errors: INVALID_ARGUMENT; FAILED_PRECONDITION the games differ.
PROCGEN_API ProcgenCode procgen_clone_states(ProcgenPool* pool, const int32_t* sources,
                                             const int32_t* targets, int32_t count);

// Converts a snapshot to JSON that people and programs read and edit: the agent, the entities and
// the cells, with names of kinds, and all other fields of a snapshot
// (envcore/environment/readable_state.h). `*json_size`: bytes of the text, without an end mark; is
// set also if `capacity` is less. Errors: RESOURCE_EXHAUSTED `capacity` is too small;
// INVALID_ARGUMENT; DATA_LOSS.
PROCGEN_API ProcgenCode procgen_state_to_json(const uint8_t* snapshot, size_t snapshot_size,
                                              char* json, size_t capacity, size_t* json_size);
// The inverse. The JSON of a snapshot gives the same bytes. If it was changed, the snapshot is
// marked as edited, and the fingerprint of its episode differs from that of every other one.
// Errors: RESOURCE_EXHAUSTED as above; INVALID_ARGUMENT a field is missing, unknown or has a value
// that no level can have.
PROCGEN_API ProcgenCode procgen_state_from_json(const char* json, size_t json_size,
                                                uint8_t* snapshot, size_t capacity,
                                                size_t* snapshot_size);
// Writes the objects of a slice: the agent first, then the goals, then all other entities, in a
// fixed order. `objects`: [env_count, object_max], environment first. `counts`: [env_count], which
// can exceed `object_max`, in [1, 4096]. In this process nothing is copied but these numbers; a
// server sends snapshots. Errors: INVALID_ARGUMENT.
PROCGEN_API ProcgenCode procgen_read_objects(ProcgenPool* pool, int32_t first_env,
                                             int32_t env_count, int32_t object_max,
                                             ProcgenObject* objects, int32_t* counts);

// Draws what a person would see: uint8 [size_px, size_px, 3], antialiased. `size_px`: in [16,
// 2048]. `whole_level`: 1: all of the level. Errors: INVALID_ARGUMENT.
PROCGEN_API ProcgenCode procgen_render(ProcgenPool* pool, int32_t environment, int32_t size_px,
                                       uint8_t whole_level, uint8_t* frame);

#ifdef __cplusplus
}  // extern "C"
#endif

// NOLINTEND(modernize-*,readability-identifier-naming)
#endif  // CLIENTS_C_PROCGEN_H_
