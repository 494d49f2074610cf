// Claims of the C tests: one that does not hold ends the program with its place and its text.
#ifndef TESTS_CLIENTS_LIBENV_CLAIM_H_
#define TESTS_CLIENTS_LIBENV_CLAIM_H_

#include <stdio.h>
#include <stdlib.h>

// The exit status that says that a claim cannot be checked here.
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
