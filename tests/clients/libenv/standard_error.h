// Captures what the library writes to standard error.
#ifndef TESTS_CLIENTS_LIBENV_STANDARD_ERROR_H_
#define TESTS_CLIENTS_LIBENV_STANDARD_ERROR_H_

enum { kSaidBytes = 4096 };

struct CapturedOutput {
  char text[kSaidBytes];
  int line_count;
};

// Captures standard error until EndListening, which returns it.
void BeginListening(void);
struct CapturedOutput EndListening(void);

#endif  // TESTS_CLIENTS_LIBENV_STANDARD_ERROR_H_
