#include <limits.h>
#include <string.h>

#include "tests/clients/libenv/claim.h"
#include "tests/clients/libenv/claims.h"
#include "tests/clients/libenv/host.h"
#include "tests/clients/libenv/standard_error.h"

void VersionIsOne(void) { CLAIM(libenv.version() == 1); }

// The layout that hosts were compiled against.
void LayoutMatchesTheDocumentation(void) {
  CLAIM(sizeof(union LibenvValue) == 4);
  CLAIM(sizeof(struct LibenvTensorType) == 128 + 4 + 4 + 16 * 4 + 4 + 4 + 4);
  CLAIM(offsetof(struct LibenvTensorType, scalar_type) == 128);
  CLAIM(offsetof(struct LibenvTensorType, value_type) == 132);
  CLAIM(offsetof(struct LibenvTensorType, shape) == 136);
  CLAIM(offsetof(struct LibenvTensorType, dimension_count) == 200);
  CLAIM(offsetof(struct LibenvTensorType, low) == 204);
  CLAIM(offsetof(struct LibenvTensorType, high) == 208);
  CLAIM(sizeof(struct LibenvOption) == 144);
  CLAIM(offsetof(struct LibenvOption, value_type) == 128);
  CLAIM(offsetof(struct LibenvOption, count) == 132);
  CLAIM(offsetof(struct LibenvOption, data) == 136);
  CLAIM(sizeof(struct LibenvOptions) == 16 && offsetof(struct LibenvOptions, count) == 8);
  CLAIM(sizeof(struct LibenvBuffers) == 40);
  CLAIM(offsetof(struct LibenvBuffers, rewards) == 8);
  CLAIM(offsetof(struct LibenvBuffers, firsts) == 16);
  CLAIM(offsetof(struct LibenvBuffers, infos) == 24);
  CLAIM(offsetof(struct LibenvBuffers, actions) == 32);
}

static void ClaimIsPicture(const struct LibenvTensorType* type, int size_px) {
  CLAIM(strcmp(type->name, "rgb") == 0);
  CLAIM(type->scalar_type == kLibenvDiscrete && type->value_type == kLibenvUint8);
  CLAIM(type->dimension_count == 3);
  CLAIM(type->shape[0] == size_px && type->shape[1] == size_px && type->shape[2] == 3);
  CLAIM(type->low.uint8 == 0 && type->high.uint8 == 255);
}

static void ClaimIsInt32(const struct LibenvTensorType* type, const char* name, int32_t high) {
  CLAIM(strcmp(type->name, name) == 0);
  CLAIM(type->scalar_type == kLibenvDiscrete && type->value_type == kLibenvInt32);
  CLAIM(type->dimension_count == 0 && type->low.int32 == 0 && type->high.int32 == high);
}

static void ClaimInfos(const struct LibenvTensorType types[]) {
  ClaimIsInt32(&types[0], "prev_level_seed", INT_MAX);
  CLAIM(strcmp(types[1].name, "prev_level_complete") == 0);
  CLAIM(types[1].scalar_type == kLibenvDiscrete && types[1].value_type == kLibenvUint8);
  CLAIM(types[1].dimension_count == 0 && types[1].low.uint8 == 0 && types[1].high.uint8 == 1);
  ClaimIsInt32(&types[2], "level_seed", INT_MAX);
}

void SpacesMatchTheDocumentation(void) {
  const struct OptionList list = RequiredOptions("coinrun");
  struct LibenvHandle* handle = Make(1, &list);
  CLAIM(handle != NULL);
  struct LibenvTensorType types[4];
  CLAIM(libenv.get_tensortypes(handle, kLibenvObservation, NULL) == 1);
  CLAIM(libenv.get_tensortypes(handle, kLibenvObservation, types) == 1);
  ClaimIsPicture(&types[0], 64);
  CLAIM(libenv.get_tensortypes(handle, kLibenvAction, types) == 1);
  ClaimIsInt32(&types[0], "action", 14);
  CLAIM(libenv.get_tensortypes(handle, kLibenvInfo, types) == 3);
  ClaimInfos(types);
  CLAIM(libenv.get_tensortypes(handle, kLibenvSpaceUnused, types) == 0);
  CLAIM(libenv.get_tensortypes(handle, 77, types) == 0);
  libenv.close(handle);
}

void RenderHumanAddsAnInfo(void) {
  struct OptionList list = RequiredOptions("coinrun");
  AddBoolean(&list, "render_human", 1);
  struct LibenvHandle* handle = Make(1, &list);
  CLAIM(handle != NULL);
  struct LibenvTensorType types[4];
  CLAIM(libenv.get_tensortypes(handle, kLibenvInfo, types) == 4);
  ClaimInfos(types);
  ClaimIsPicture(&types[3], 512);
  libenv.close(handle);
}

// Expects that libenv_make fails and writes one line that contains `words`.
static void ClaimIsRejected(int env_count, const struct OptionList* list, const char* words) {
  BeginListening();
  struct LibenvHandle* handle = Make(env_count, list);
  const struct CapturedOutput said = EndListening();
  CLAIM(handle == NULL);
  CLAIM(said.line_count == 1);
  CLAIM(strstr(said.text, words) != NULL);
}

static void ClaimIntegerIsRejected(const char* name, int32_t value, const char* words) {
  struct OptionList list = RequiredOptions("coinrun");
  for (int i = 0; i < list.count; ++i) {
    if (strcmp(list.items[i].name, name) == 0) {
      list.integers[i] = value;
      ClaimIsRejected(1, &list, words);
      return;
    }
  }
  AddInteger(&list, name, value);
  ClaimIsRejected(1, &list, words);
}

static void ClaimMissingIsRejected(int missing, const char* name) {
  struct OptionList list = RequiredOptions("coinrun");
  snprintf(list.items[missing].name, sizeof(list.items[missing].name), "num_levels");
  if (missing == 0) {
    list.items[missing].value_type = kLibenvInt32;
    list.items[missing].count = 1;
    list.items[missing].data = NULL;
  }
  ClaimIsRejected(1, &list, name);
}

void InvalidOptionErrorIsOneLine(void) {
  const struct OptionList good = RequiredOptions("coinrun");
  ClaimIsRejected(0, &good, "env_count");
  ClaimIsRejected(-5, &good, "env_count");
  ClaimIsRejected(INT_MAX, &good, "env_count");
  struct OptionList list = RequiredOptions("coinrum");
  ClaimIsRejected(1, &list, "coinrum");
  list = RequiredOptions("");
  ClaimIsRejected(1, &list, "game");
  list = RequiredOptions("coinrun,maze");
  ClaimIsRejected(3, &list, "multiple");
  ClaimMissingIsRejected(0, "env_name");
  ClaimMissingIsRejected(1, "num_actions");
  ClaimMissingIsRejected(2, "start_level");
  ClaimIntegerIsRejected("frame_skip", 4, "frame_skip");
  ClaimIntegerIsRejected("num_levels", -1, "num_levels");
  ClaimIntegerIsRejected("start_level", -1, "start_level");
  ClaimIntegerIsRejected("num_actions", 0, "num_actions");
  ClaimIntegerIsRejected("num_actions", 16, "num_actions");
  ClaimIntegerIsRejected("num_threads", -1, "num_threads");
  ClaimIntegerIsRejected("num_threads", INT_MAX, "num_threads");
  ClaimIntegerIsRejected("distribution_mode", 3, "distribution_mode");
  ClaimIntegerIsRejected("distribution_mode", 20, "distribution_mode");
  // Coinrun has no extreme mode and no memory mode.
  ClaimIntegerIsRejected("distribution_mode", 2, "distribution_mode");
  ClaimIntegerIsRejected("distribution_mode", 10, "distribution_mode");
}

void MalformedOptionErrorIsOneLine(void) {
  struct OptionList list = RequiredOptions("coinrun");
  AddBoolean(&list, "center_agent", 2);
  ClaimIsRejected(1, &list, "center_agent");
  list = RequiredOptions("coinrun");
  AddInteger(&list, "center_agent", 1);
  ClaimIsRejected(1, &list, "center_agent");
  list = RequiredOptions("coinrun");
  AddInteger(&list, "rand_seed", 1);
  list.items[list.count - 1].count = 2;
  ClaimIsRejected(1, &list, "rand_seed");
  list = RequiredOptions("coinrun");
  AddInteger(&list, "start_level", 1);
  ClaimIsRejected(1, &list, "twice");
  list = RequiredOptions("coinrun");
  list.items[0].count = -1;
  ClaimIsRejected(1, &list, "env_name");
  list = RequiredOptions("coinrun");
  memset(list.items[1].name, 'x', sizeof(list.items[1].name));
  ClaimIsRejected(1, &list, "terminating zero");
  BeginListening();
  const struct LibenvOptions none = {.items = NULL, .count = 3};
  CLAIM(libenv.make(1, none) == NULL);
  CLAIM(EndListening().line_count == 1);
}

// Digest of 20 steps of two environments.
static uint32_t Play(const struct OptionList* list) {
  struct Host host = OpenHost(2, list);
  uint32_t digest = kDigestBegin;
  for (int step = 0; step < 20; ++step) {
    ActAll(&host, step % 15);
    libenv.observe(host.handle);
    const uint32_t now = DigestOfHost(&host);
    digest = Digest(digest, &now, sizeof(now));
  }
  CloseHost(&host);
  return digest;
}

void MissingOptionsHaveTheDefaults(void) {
  static const char* const kFalse[] = {"center_agent",         "use_sequential_levels",
                                       "use_generated_assets", "use_monochrome_assets",
                                       "restrict_themes",      "paint_vel_info"};
  // Maze depends on center_agent, coinrun on themes and backgrounds.
  struct OptionList list = RequiredOptions("coinrun,maze");
  const uint32_t expected = Play(&list);
  AddInteger(&list, "num_levels", 0);
  AddInteger(&list, "distribution_mode", 0);
  AddInteger(&list, "rand_seed", 0);
  AddInteger(&list, "debug_mode", 0);
  AddInteger(&list, "num_threads", 4);
  AddBoolean(&list, "use_backgrounds", 1);
  AddBoolean(&list, "render_human", 0);
  for (size_t i = 0; i < sizeof(kFalse) / sizeof(*kFalse); ++i) {
    AddBoolean(&list, kFalse[i], 0);
  }
  CLAIM(Play(&list) == expected);
  struct OptionList other = RequiredOptions("coinrun,maze");
  AddInteger(&other, "rand_seed", 1);
  CLAIM(Play(&other) != expected);
  other = RequiredOptions("coinrun,maze");
  AddInteger(&other, "distribution_mode", 1);
  CLAIM(Play(&other) != expected);
}

void AllOptionsAreAccepted(void) {
  struct OptionList list = RequiredOptions("jumper");
  const uint32_t expected = Play(&list);
  AddString(&list, "resource_root", "/nowhere/at/all/");
  AddInteger(&list, "plain_assets", 1);
  AddInteger(&list, "physics_mode", 1);
  AddInteger(&list, "game_type", 1);
  AddBoolean(&list, "use_easy_jump", 1);
  CLAIM(Play(&list) == expected);
}
