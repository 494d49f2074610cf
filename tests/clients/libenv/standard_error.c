#include "tests/clients/libenv/standard_error.h"

#include <string.h>
#include <unistd.h>

#include "tests/clients/libenv/claim.h"

static FILE* kept = NULL;
static int real_standard_error = -1;

void BeginListening(void) {
  fflush(stderr);
  kept = tmpfile();
  CLAIM(kept != NULL);
  real_standard_error = dup(STDERR_FILENO);
  CLAIM(real_standard_error >= 0 && dup2(fileno(kept), STDERR_FILENO) >= 0);
}

struct CapturedOutput EndListening(void) {
  struct CapturedOutput said;
  memset(&said, 0, sizeof(said));
  fflush(stderr);
  dup2(real_standard_error, STDERR_FILENO);
  close(real_standard_error);
  rewind(kept);
  const size_t size = fread(said.text, 1, sizeof(said.text) - 1, kept);
  fclose(kept);
  for (size_t i = 0; i < size; ++i) {
    said.line_count += said.text[i] == '\n';
  }
  // Also written to the real standard error, for the log of a failed test.
  fputs(said.text, stderr);
  return said;
}
