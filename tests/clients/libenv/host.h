// A host like the Python package: loads libenv.so by its path, makes environments, and owns the
// memory of their observations.
#ifndef TESTS_CLIENTS_LIBENV_HOST_H_
#define TESTS_CLIENTS_LIBENV_HOST_H_

#include <stddef.h>
#include <stdint.h>

#include "clients/libenv/libenv.h"

enum {
  kOptionCountMax = 32,
  kPictureBytes = 64 * 64 * 3,
  kHumanViewBytes = 512 * 512 * 3,
  kGuardBytes = 16,  // after each value, to detect writes beyond it
};

// The functions of the loaded library.
struct Interface {
  int (*version)(void);
  struct LibenvHandle* (*make)(int, struct LibenvOptions);
  int (*get_tensortypes)(struct LibenvHandle*, int, struct LibenvTensorType*);
  void (*set_buffers)(struct LibenvHandle*, struct LibenvBuffers*);
  void (*observe)(struct LibenvHandle*);
  void (*act)(struct LibenvHandle*);
  void (*close)(struct LibenvHandle*);
  int (*get_state)(struct LibenvHandle*, int, char*, int);
  void (*set_state)(struct LibenvHandle*, int, char*, int);
};

extern struct Interface libenv;
void LoadInterface(const char* path);

// A list of options, filled by the functions below.
struct OptionList {
  struct LibenvOption items[kOptionCountMax];
  int32_t integers[kOptionCountMax];
  uint8_t booleans[kOptionCountMax];
  int count;
};

void AddInteger(struct OptionList* list, const char* name, int32_t value);
void AddBoolean(struct OptionList* list, const char* name, int value);
// `text` must stay valid until Make returns.
void AddString(struct OptionList* list, const char* name, const char* text);
// A list of the required options: env_name `games`, num_actions 15, start_level 0.
struct OptionList RequiredOptions(const char* games);

// Calls libenv_make with the list. Frees the options before it returns.
struct LibenvHandle* Make(int env_count, const struct OptionList* list);

// Environments with their buffers. The values of a member are separate allocations.
struct Host {
  struct LibenvHandle* handle;
  int env_count;
  int has_human_view;
  uint8_t** pictures;             // [N] to [64, 64, 3]
  float* rewards;                 // [N]
  uint8_t* firsts;                // [N]
  int32_t** prev_level_seeds;     // [N] to one
  uint8_t** prev_level_complete;  // [N] to one
  int32_t** level_seeds;          // [N] to one
  uint8_t** human_views;          // [N] to [512, 512, 3]
  int32_t** actions;              // [N] to one
};

// Makes environments, which must succeed, and sets buffers. Nothing is observed yet.
struct Host OpenHost(int env_count, const struct OptionList* list);
// Sets the action of every environment and calls libenv_act.
void ActAll(struct Host* host, int32_t action);
// Closes the handle, checks the guard bytes and frees the buffers.
void CloseHost(struct Host* host);
// Digest of all results of libenv_observe.
uint32_t DigestOfHost(const struct Host* host);
// 32-bit FNV-1a of `bytes`, continued from `digest`; starts with kDigestBegin.
static const uint32_t kDigestBegin = 2166136261U;
uint32_t Digest(uint32_t digest, const void* bytes, size_t size);

#endif  // TESTS_CLIENTS_LIBENV_HOST_H_
