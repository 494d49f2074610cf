// A procgen-server of the test's own.
#ifndef TESTS_CLIENTS_LIBENV_SERVER_PROCESS_H_
#define TESTS_CLIENTS_LIBENV_SERVER_PROCESS_H_

// Starts the program on a port that the system chooses and has PROCGEN_SERVER hold its address. It
// asks for a token, which PROCGEN_SERVER_TOKEN holds. It ends with this process at the latest. To
// be called before there are threads.
void StartServer(const char* program);
// Ends it at once, as if its machine had gone.
void KillServer(void);

#endif  // TESTS_CLIENTS_LIBENV_SERVER_PROCESS_H_
