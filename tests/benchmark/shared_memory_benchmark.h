#ifndef TESTS_BENCHMARK_SHARED_MEMORY_BENCHMARK_H_
#define TESTS_BENCHMARK_SHARED_MEMORY_BENCHMARK_H_

namespace procgen {

// Adds stream/shm/environments:N: a learner that shares memory with the server, beside the same
// pool stepped in the process.
void RegisterSharedMemoryStreams();

}  // namespace procgen

#endif  // TESTS_BENCHMARK_SHARED_MEMORY_BENCHMARK_H_
