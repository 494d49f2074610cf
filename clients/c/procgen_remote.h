// libprocgen_remote: libprocgen, and pools on servers behind the same functions.
//
//   ProcgenConnection* connection;
//   ProcgenPool* pool;
//   if (procgen_connect("127.0.0.1:50051", NULL, &connection) != PROCGEN_OK ||
//       procgen_connection_create_pool(connection, &options, NULL, &pool) != PROCGEN_OK) {
//     puts(procgen_error_message());
//   }
//
// All functions of procgen.h work on either kind of pool, with equal results. Of a pool on a
// server:
// - It survives broken connections and restarts of its server: it is made again from a checkpoint
// and
//   the requests since, with equal results (reconnect_timeout_s).
// - Up to 16 requests can be unanswered. Sending more is FAILED_PRECONDITION.
// - A request that the server rejects changes nothing, and the pool continues. After CANCELLED,
//   UNAVAILABLE and other errors of the connection, every request fails with that error.
// - procgen_restore_states is not all or nothing if the snapshots are larger than a request of the
//   server may be (4 MiB by default).
//
// Messages are those of proto/procgen/v1. Errors are the server's codes and messages; UNAVAILABLE
// if it cannot be reached. Threads: one connection from any threads; one watch from one thread at a
// time, except procgen_watch_stop. Fork: a connection and what was made with it belong to the
// process that connected. In a forked child, calls fail with FAILED_PRECONDITION, also
// procgen_connect; close, stop and destroy do nothing.
#ifndef CLIENTS_C_PROCGEN_REMOTE_H_
#define CLIENTS_C_PROCGEN_REMOTE_H_

#include "procgen.h"

// NOLINTBEGIN(modernize-*,readability-identifier-naming)

#ifdef __cplusplus
extern "C" {
#endif

// A connection to a server. Opaque.
typedef struct ProcgenConnection ProcgenConnection;
// A stream of messages from a server. Opaque.
typedef struct ProcgenWatch ProcgenWatch;

// How observations travel. Both give the same bytes.
typedef enum ProcgenEncoding {
  PROCGEN_RAW = 0,
  PROCGEN_DELTA_ZSTD = 1,  // compressed differences to the observation before
} ProcgenEncoding;

typedef struct ProcgenConnectOptions {
  size_t struct_size;
  double timeout_s;       // to wait for the server, which may be starting; negative: 10, or 1.5
                          // if nothing listens
  double call_timeout_s;  // of each call other than steps; negative: none
  double reconnect_timeout_s;  // in which a pool is made again after a broken connection; 0: a
                               // broken connection ends it
  // Null: none. PEM texts, not paths. `ca` selects TLS; certificate and key need each other and it.
  const char* ca;           // certificates that sign the server's
  const char* certificate;  // of the client, if the server requires one
  const char* key;
  const char* token;            // without TLS it is sent only to this machine
  uint8_t token_in_plain_text;  // 1: to any machine
} ProcgenConnectOptions;

typedef struct ProcgenServerPoolOptions {
  size_t struct_size;
  const char* pool_id;  // last part of its name; null: chosen by the server
  int32_t encoding;     // a ProcgenEncoding; PROCGEN_RAW
  // For people, in pages and lists: a name of at most 128 bytes, and up to 16 labels, "key=value".
  const char* display_name;  // null: none
  const char* const* labels;
  int32_t label_count;
} ProcgenServerPoolOptions;

// Connects to `address`, "host:port" or "unix:path", or to several, separated by commas. A name
// with several IPv4 addresses stands for a server at each; "cluster:host:port" for all servers of
// the cluster of that one. Pools are spread over several servers by their threads and load; one
// that is lost is replaced by another until it is back, with equal results. At least one must
// answer. Null `options`: timeouts -1, -1 and 60, and nothing else.
// Errors: INVALID_ARGUMENT; UNAVAILABLE; CANCELLED; FAILED_PRECONDITION in a fork of a process that
// has connected.
PROCGEN_API ProcgenCode procgen_connect(const char* address, const ProcgenConnectOptions* options,
                                        ProcgenConnection** connection);
// Ends running calls and waits of the connection, its pools and its watches with CANCELLED, and all
// later ones. From any thread.
PROCGEN_API void procgen_connection_close(ProcgenConnection* connection);
// Closes the connection and frees it. No other call of it may run. Pools and watches must still be
// destroyed, before or after. Null is ignored.
PROCGEN_API void procgen_connection_destroy(ProcgenConnection* connection);

// Calls a unary method by its path, "/procgen.v1.PoolService/GetPool", with a serialised request.
// `response`: the serialised response; free it with procgen_free. Not validated.
PROCGEN_API ProcgenCode procgen_connection_call(ProcgenConnection* connection, const char* path,
                                                const uint8_t* request, size_t request_size,
                                                uint8_t** response, size_t* response_size);
// Frees a message. Null is ignored.
PROCGEN_API void procgen_free(void* memory);

// Calls a method with a stream of responses by its path, "/procgen.v1.PoolService/WatchPool".
// Errors of the server come with procgen_watch_next.
PROCGEN_API ProcgenCode procgen_connection_watch(ProcgenConnection* connection, const char* path,
                                                 const uint8_t* request, size_t request_size,
                                                 ProcgenWatch** watch);
// Waits for a message that was not returned before; only the latest is kept. `timeout_s`: seconds;
// negative: no limit. `message`: free it with procgen_free. Errors: DEADLINE_EXCEEDED none yet,
// call again; CANCELLED; UNAVAILABLE the server ended the stream; those of the server.
PROCGEN_API ProcgenCode procgen_watch_next(ProcgenWatch* watch, double timeout_s, uint8_t** message,
                                           size_t* size);
// Ends the stream, from any thread: procgen_watch_next fails with CANCELLED.
PROCGEN_API void procgen_watch_stop(ProcgenWatch* watch);
// Ends the stream and frees it. Null is ignored.
PROCGEN_API void procgen_watch_destroy(ProcgenWatch* watch);

// Creates a pool on the server. procgen_pool_destroy deletes it, for which it waits for at most a
// second. `options->art` must be null: the server has its own; num_threads is not used. Null
// `server_options`: defaults. Errors: INVALID_ARGUMENT, NOT_FOUND; ALREADY_EXISTS the pool_id is
// taken; RESOURCE_EXHAUSTED a limit of the server; those of the connection.
PROCGEN_API ProcgenCode
procgen_connection_create_pool(ProcgenConnection* connection, const ProcgenPoolOptions* options,
                               const ProcgenServerPoolOptions* server_options, ProcgenPool** pool);
// "pools/7"; "" for a pool in this process. Valid until the pool is destroyed.
PROCGEN_API const char* procgen_pool_name(const ProcgenPool* pool);

#ifdef __cplusplus
}  // extern "C"
#endif

// NOLINTEND(modernize-*,readability-identifier-naming)
#endif  // CLIENTS_C_PROCGEN_REMOTE_H_
