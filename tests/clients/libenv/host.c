#include "tests/clients/libenv/host.h"

#include <dlfcn.h>
#include <string.h>

#include "tests/clients/libenv/claim.h"

struct Interface libenv;

static void* Find(void* library, const char* name) {
  void* found = dlsym(library, name);
  if (found == NULL) {
    printf("libenv.so has no %s\n", name);
    exit(EXIT_FAILURE);
  }
  return found;
}

// RTLD_LOCAL, as in the Python package.
void LoadInterface(const char* path) {
  void* library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (library == NULL) {
    printf("%s\n", dlerror());
    exit(EXIT_FAILURE);
  }
  // POSIX says that a function's address survives the void pointer; ISO C does not.
  *(void**)&libenv.version = Find(library, "libenv_version");
  *(void**)&libenv.make = Find(library, "libenv_make");
  *(void**)&libenv.get_tensortypes = Find(library, "libenv_get_tensortypes");
  *(void**)&libenv.set_buffers = Find(library, "libenv_set_buffers");
  *(void**)&libenv.observe = Find(library, "libenv_observe");
  *(void**)&libenv.act = Find(library, "libenv_act");
  *(void**)&libenv.close = Find(library, "libenv_close");
  *(void**)&libenv.get_state = Find(library, "get_state");
  *(void**)&libenv.set_state = Find(library, "set_state");
}

static struct LibenvOption* Add(struct OptionList* list, const char* name, int value_type,
                                int count) {
  CLAIM(list->count < kOptionCountMax);
  struct LibenvOption* option = &list->items[list->count++];
  memset(option, 0, sizeof(*option));
  snprintf(option->name, sizeof(option->name), "%s", name);
  option->value_type = value_type;
  option->count = count;
  return option;
}

// Integers and booleans are stored in the list; Make sets their addresses, as lists may be copied.
void AddInteger(struct OptionList* list, const char* name, int32_t value) {
  list->integers[list->count] = value;
  Add(list, name, kLibenvInt32, 1);
}

void AddBoolean(struct OptionList* list, const char* name, int value) {
  list->booleans[list->count] = (uint8_t)value;
  Add(list, name, kLibenvUint8, 1);
}

void AddString(struct OptionList* list, const char* name, const char* text) {
  Add(list, name, kLibenvUint8, (int)strlen(text))->data = (void*)text;
}

struct OptionList RequiredOptions(const char* games) {
  struct OptionList list;
  memset(&list, 0, sizeof(list));
  AddString(&list, "env_name", games);
  AddInteger(&list, "num_actions", 15);
  AddInteger(&list, "start_level", 0);
  return list;
}

struct LibenvHandle* Make(int env_count, const struct OptionList* list) {
  // On the heap, so that AddressSanitizer detects a library that reads it later.
  struct OptionList* copy = malloc(sizeof(*copy));
  CLAIM(copy != NULL);
  *copy = *list;
  for (int i = 0; i < copy->count; ++i) {
    struct LibenvOption* option = &copy->items[i];
    if (option->data == NULL) {
      option->data = option->value_type == kLibenvInt32 ? (void*)&copy->integers[i]
                                                        : (void*)&copy->booleans[i];
    }
  }
  const struct LibenvOptions options = {.items = copy->items, .count = copy->count};
  struct LibenvHandle* handle = libenv.make(env_count, options);
  free(copy);
  return handle;
}

// Memory for `count` values of `bytes` each: separate allocations, each followed by a guard.
static void* NewValues(int count, size_t bytes) {
  uint8_t** values = malloc((size_t)count * sizeof(*values));
  CLAIM(values != NULL);
  for (int i = 0; i < count; ++i) {
    values[i] = malloc(bytes + kGuardBytes);
    CLAIM(values[i] != NULL);
    memset(values[i], 0x5a, bytes + kGuardBytes);
  }
  return values;
}

static void FreeValues(void* pointers, int count, size_t bytes) {
  uint8_t** values = pointers;
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < kGuardBytes; ++k) {
      CLAIM(values[i][bytes + (size_t)k] == 0x5a);
    }
    free(values[i]);
  }
  free(values);
}

static void SetBuffers(struct Host* host) {
  const size_t n = (size_t)host->env_count;
  const size_t pointer = sizeof(void*);
  void** infos = malloc(4 * n * pointer);
  void** observations = malloc(n * pointer);
  void** actions = malloc(n * pointer);
  CLAIM(infos != NULL && observations != NULL && actions != NULL);
  memcpy(observations, host->pictures, n * pointer);
  memcpy(actions, host->actions, n * pointer);
  memcpy(infos, host->prev_level_seeds, n * pointer);
  memcpy(infos + n, host->prev_level_complete, n * pointer);
  memcpy(infos + 2 * n, host->level_seeds, n * pointer);
  if (host->has_human_view) {
    memcpy(infos + 3 * n, host->human_views, n * pointer);
  }
  struct LibenvBuffers buffers = {.observations = observations,
                                  .rewards = host->rewards,
                                  .firsts = host->firsts,
                                  .infos = infos,
                                  .actions = actions};
  libenv.set_buffers(host->handle, &buffers);
  // The library must keep the addresses of the values, not these arrays.
  free(infos);
  free(observations);
  free(actions);
}

struct Host OpenHost(int env_count, const struct OptionList* list) {
  struct Host host = {.env_count = env_count};
  host.handle = Make(env_count, list);
  CLAIM(host.handle != NULL);
  const int n = env_count;
  host.has_human_view = libenv.get_tensortypes(host.handle, kLibenvInfo, NULL) == 4;
  host.pictures = NewValues(n, kPictureBytes);
  host.rewards = calloc((size_t)n, sizeof(float));
  host.firsts = calloc((size_t)n, 1);
  host.prev_level_seeds = NewValues(n, sizeof(int32_t));
  host.prev_level_complete = NewValues(n, 1);
  host.level_seeds = NewValues(n, sizeof(int32_t));
  host.human_views = NewValues(host.has_human_view ? n : 0, kHumanViewBytes);
  host.actions = NewValues(n, sizeof(int32_t));
  SetBuffers(&host);
  return host;
}

void ActAll(struct Host* host, int32_t action) {
  for (int i = 0; i < host->env_count; ++i) {
    *host->actions[i] = action;
  }
  libenv.act(host->handle);
}

void CloseHost(struct Host* host) {
  libenv.close(host->handle);
  const int n = host->env_count;
  FreeValues(host->pictures, n, kPictureBytes);
  FreeValues(host->prev_level_seeds, n, sizeof(int32_t));
  FreeValues(host->prev_level_complete, n, 1);
  FreeValues(host->level_seeds, n, sizeof(int32_t));
  FreeValues(host->human_views, host->has_human_view ? n : 0, kHumanViewBytes);
  FreeValues(host->actions, n, sizeof(int32_t));
  free(host->rewards);
  free(host->firsts);
}

uint32_t Digest(uint32_t digest, const void* bytes, size_t size) {
  const uint8_t* at = bytes;
  for (size_t i = 0; i < size; ++i) {
    digest = (digest ^ at[i]) * 16777619U;
  }
  return digest;
}

uint32_t DigestOfHost(const struct Host* host) {
  const size_t n = (size_t)host->env_count;
  uint32_t digest = Digest(kDigestBegin, host->rewards, n * sizeof(float));
  digest = Digest(digest, host->firsts, n);
  for (size_t i = 0; i < n; ++i) {
    digest = Digest(digest, host->pictures[i], kPictureBytes);
    digest = Digest(digest, host->prev_level_seeds[i], sizeof(int32_t));
    digest = Digest(digest, host->prev_level_complete[i], 1);
    digest = Digest(digest, host->level_seeds[i], sizeof(int32_t));
    if (host->has_human_view) {
      digest = Digest(digest, host->human_views[i], kHumanViewBytes);
    }
  }
  return digest;
}
