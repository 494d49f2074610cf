/* procgen_remote.h in C99: a pool in the process, and a server that is not there. */
#include <stdio.h>

#include "procgen_remote.h"

int main(void) {
  ProcgenPoolOptions options;
  procgen_pool_options_init(&options, sizeof(options));
  const char* games[] = {"coinrun"};
  options.games = games;
  options.game_count = 1;
  options.env_count = 2;
  ProcgenPool* pool = NULL;
  if (procgen_pool_create(&options, &pool) != PROCGEN_OK) {
    puts(procgen_error_message());
    return 1;
  }
  printf("pool '%s'\n", procgen_pool_name(pool));
  procgen_pool_destroy(pool);
  ProcgenConnectOptions connect = {.struct_size = sizeof(connect)};
  ProcgenConnection* connection = NULL;
  const ProcgenCode code = procgen_connect("127.0.0.1:1", &connect, &connection);
  puts(procgen_error_message());
  return code == PROCGEN_UNAVAILABLE ? 0 : 1;
}
