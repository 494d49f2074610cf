/* The example of procgen.h in C99, and one step. */
#include <stdio.h>
#include <stdlib.h>

#include "procgen.h"

int main(void) {
  ProcgenPoolOptions options;
  procgen_pool_options_init(&options, sizeof(options));
  const char* games[] = {"coinrun"};
  options.games = games;
  options.game_count = 1;
  options.env_count = 64;
  ProcgenPool* pool = NULL;
  if (procgen_pool_create(&options, &pool) != PROCGEN_OK) {
    puts(procgen_error_message());
    return 1;
  }
  int32_t actions[64] = {0};
  static uint8_t observations[64 * 64 * 64 * 3];
  ProcgenStep step = {.struct_size = sizeof(step), .env_count = 64, .actions = actions};
  ProcgenBatch batch = {.struct_size = sizeof(batch), .observations = observations};
  ProcgenCode code = procgen_step(pool, &step, &batch);
  long sum = 0;
  for (size_t i = 0; i < sizeof(observations); ++i) {
    sum += observations[i];
  }
  procgen_pool_destroy(pool);
  printf("%s: code %d, pixels %s\n", procgen_version(), (int)code, sum > 0 ? "drawn" : "missing");
  return code == PROCGEN_OK && sum > 0 ? 0 : 1;
}
