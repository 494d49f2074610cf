#include "tests/clients/libenv/server_process.h"

#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/clients/libenv/claim.h"

static pid_t server_process = 0;
// The server's token file. The server requires a token, so all claims use a host that sends one.
static char tokens_path[] = "/tmp/procgen-libenv-tokens-XXXXXX";
static const char kToken[] = "libenv-token-0123456789";

static void WriteTokens(void) {
  const int file = mkstemp(tokens_path);
  CLAIM(file >= 0);
  CLAIM(dprintf(file, "host %s\n", kToken) > 0);
  CLAIM(close(file) == 0);
  CLAIM(setenv("PROCGEN_SERVER_TOKEN", kToken, 1) == 0);
}

void StartServer(const char* program) {
  WriteTokens();
  char tokens[sizeof(tokens_path) + 16];
  snprintf(tokens, sizeof(tokens), "--tokens=%s", tokens_path);
  int ends[2];
  CLAIM(pipe(ends) == 0);
  server_process = fork();
  CLAIM(server_process >= 0);
  if (server_process == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    execl(program, program, "--address=127.0.0.1:0", "--log_level=error", tokens, (char*)NULL);
    _exit(127);
  }
  close(ends[1]);
  FILE* output = fdopen(ends[0], "r");
  CLAIM(output != NULL);
  char address[256] = "";
  char line[256];
  while (address[0] == '\0' && fgets(line, sizeof(line), output) != NULL) {
    sscanf(line, "listening on %255s", address);
  }
  fclose(output);
  CLAIM(address[0] != '\0');
  CLAIM(setenv("PROCGEN_SERVER", address, 1) == 0);
  atexit(KillServer);
}

void KillServer(void) {
  if (server_process > 0) {
    kill(server_process, SIGKILL);
    waitpid(server_process, NULL, 0);
    server_process = 0;
    unlink(tokens_path);
  }
}
