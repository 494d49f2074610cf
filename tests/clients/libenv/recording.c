#include "tests/clients/libenv/recording.h"

#include <string.h>

#include "tests/clients/libenv/claim.h"

// The text after `"name":` in the header, which is JSON without blanks; each name occurs once.
static const char* ValueOf(const char* header, const char* name) {
  char key[64];
  snprintf(key, sizeof(key), "\"%s\":", name);
  const char* found = strstr(header, key);
  CLAIM(found != NULL);
  return found + strlen(key);
}

static int IsTrue(const char* header, const char* name) {
  return strncmp(ValueOf(header, name), "true", 4) == 0;
}

static int32_t ModeOf(const char* header) {
  const char* value = ValueOf(header, "distribution_mode");
  if (strncmp(value, "\"easy\"", 6) == 0) {
    return 0;
  }
  if (strncmp(value, "\"hard\"", 6) == 0) {
    return 1;
  }
  return strncmp(value, "\"extreme\"", 9) == 0 ? 2 : 10;
}

static void ReadOptions(const char* header, struct Recording* recording) {
  static const char* const kIntegers[] = {"num_levels", "rand_seed", "debug_mode"};
  static const char* const kBooleans[] = {
      "use_sequential_levels", "center_agent",         "use_backgrounds", "restrict_themes",
      "use_monochrome_assets", "use_generated_assets", "paint_vel_info"};
  CLAIM(sscanf(ValueOf(header, "env_name"), "\"%63[a-z,]\"", recording->games) == 1);
  struct OptionList* list = &recording->options;
  AddString(list, "env_name", recording->games);
  AddInteger(list, "num_actions", 15);
  AddInteger(list, "start_level", (int32_t)strtol(ValueOf(header, "start_level"), NULL, 10));
  AddInteger(list, "distribution_mode", ModeOf(header));
  for (size_t i = 0; i < sizeof(kIntegers) / sizeof(*kIntegers); ++i) {
    AddInteger(list, kIntegers[i], (int32_t)strtol(ValueOf(header, kIntegers[i]), NULL, 10));
  }
  for (size_t i = 0; i < sizeof(kBooleans) / sizeof(*kBooleans); ++i) {
    AddBoolean(list, kBooleans[i], IsTrue(header, kBooleans[i]));
  }
}

// The content of a file, followed by a zero byte.
static char* ReadFile(const char* path, size_t* size) {
  FILE* file = fopen(path, "rb");
  CLAIM(file != NULL);
  CLAIM(fseek(file, 0, SEEK_END) == 0);
  *size = (size_t)ftell(file);
  rewind(file);
  char* content = calloc(*size + 1, 1);
  CLAIM(content != NULL && fread(content, 1, *size, file) == *size);
  fclose(file);
  return content;
}

// The arrays follow the header in the order of their names; checks that order.
static void CopyArrays(const char* header, const char* end, struct Recording* recording) {
  static const char* const kNames[] = {"action",           "reward",          "first",
                                       "level_seed",       "prev_level_seed", "prev_level_complete",
                                       "observation_fnv1a"};
  static const size_t kBytes[] = {1, 4, 1, 4, 4, 1, 4};
  const char* entry = ValueOf(header, "arrays");
  const char* at = header + strlen(header) + 1;
  for (size_t i = 0; i < sizeof(kNames) / sizeof(*kNames); ++i) {
    char quoted[64];
    snprintf(quoted, sizeof(quoted), "[\"%s\",", kNames[i]);
    const char* found = strstr(entry, quoted);
    if (found == NULL) {
      CLAIM(i == 6);
      break;
    }
    entry = found;
    const int rows = recording->step_count + (i == 0 ? 0 : 1);
    const size_t bytes = (size_t)rows * (size_t)recording->env_count * kBytes[i];
    CLAIM(at + bytes <= end);
    recording->arrays[i] = malloc(bytes);
    CLAIM(recording->arrays[i] != NULL);
    memcpy(recording->arrays[i], at, bytes);
    at += bytes;
  }
  CLAIM(at == end);
}

void ReadRecording(const char* path, struct Recording* recording) {
  memset(recording, 0, sizeof(*recording));
  size_t size = 0;
  recording->content = ReadFile(path, &size);
  char* const header = recording->content;
  char* const newline = strchr(header, '\n');
  CLAIM(newline != NULL);
  *newline = '\0';
  ReadOptions(header, recording);
  recording->env_count = (int)strtol(ValueOf(header, "num_envs"), NULL, 10);
  recording->step_count = (int)strtol(ValueOf(header, "steps"), NULL, 10);
  CopyArrays(header, recording->content + size, recording);
  recording->actions = recording->arrays[0];
  recording->rewards = recording->arrays[1];
  recording->firsts = recording->arrays[2];
  recording->level_seeds = recording->arrays[3];
  recording->prev_level_seeds = recording->arrays[4];
  recording->prev_level_complete = recording->arrays[5];
  const int is_flat = IsTrue(header, "use_monochrome_assets") && !IsTrue(header, "use_backgrounds");
  recording->has_upstream_art = !is_flat && !IsTrue(header, "use_generated_assets");
  recording->picture_digests = recording->arrays[6];
}

void FreeRecording(struct Recording* recording) {
  for (size_t i = 0; i < sizeof(recording->arrays) / sizeof(*recording->arrays); ++i) {
    free(recording->arrays[i]);
  }
  free(recording->content);
}
