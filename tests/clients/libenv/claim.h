// CLAIM ends the program with status 1, and prints its place and text, if its condition is false.
#ifndef TESTS_CLIENTS_LIBENV_CLAIM_H_
#define TESTS_CLIENTS_LIBENV_CLAIM_H_

#include <stdio.h>
#include <stdlib.h>

// Exit status of a test that is skipped because its prerequisites are missing.
enum { kSkipped = 77 };

#define CLAIM(condition)                                                      \
  do {                                                                        \
    if (!(condition)) {                                                       \
      fprintf(stdout, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition); \
      fflush(stdout);                                                         \
      exit(EXIT_FAILURE);                                                     \
    }                                                                         \
  } while (0)

#endif  // TESTS_CLIENTS_LIBENV_CLAIM_H_
