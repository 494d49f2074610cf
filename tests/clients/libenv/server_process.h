// A procgen-server process for the test.
#ifndef TESTS_CLIENTS_LIBENV_SERVER_PROCESS_H_
#define TESTS_CLIENTS_LIBENV_SERVER_PROCESS_H_

// Starts the program on a port that the system chooses. Sets PROCGEN_SERVER to its address and
// PROCGEN_SERVER_TOKEN to the token that it requires. It ends with this process at the latest. Call
// it before any thread is started.
void StartServer(const char* program);
// Kills it, as if its machine had failed.
void KillServer(void);

#endif  // TESTS_CLIENTS_LIBENV_SERVER_PROCESS_H_
