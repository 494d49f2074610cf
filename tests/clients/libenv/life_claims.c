#include <dirent.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "tests/clients/libenv/claim.h"
#include "tests/clients/libenv/claims.h"
#include "tests/clients/libenv/host.h"
#include "tests/clients/libenv/standard_error.h"

// Sanitizers delay reuse of freed memory, so the resident size is not comparable. AddressSanitizer
// detects leaks itself.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
static const long kGrowthPagesMax = 1L << 30;
#else
static const long kGrowthPagesMax = 2048;  // 8 MiB over a thousand handles
#endif

void MisuseErrorIsOneLine(void) {
  const struct OptionList list = RequiredOptions("coinrun");
  struct LibenvHandle* handle = Make(1, &list);
  CLAIM(handle != NULL);
  libenv.close(NULL);
  BeginListening();
  libenv.observe(handle);
  libenv.act(handle);
  libenv.set_buffers(handle, NULL);
  struct LibenvBuffers buffers;
  memset(&buffers, 0, sizeof(buffers));
  libenv.set_buffers(handle, &buffers);
  libenv.observe(NULL);
  libenv.act(NULL);
  libenv.set_buffers(NULL, &buffers);
  CLAIM(libenv.get_tensortypes(NULL, kLibenvInfo, NULL) == 0);
  CLAIM(libenv.get_state(NULL, 0, NULL, 0) == 0);
  libenv.set_state(NULL, 0, NULL, -1);
  CLAIM(EndListening().line_count == 10);
  libenv.close(handle);
}

void CloseIsAllowedAtAnyTime(void) {
  const struct OptionList list = RequiredOptions("coinrun");
  struct LibenvHandle* handle = Make(2, &list);
  CLAIM(handle != NULL);
  libenv.close(handle);
  struct Host unobserved = OpenHost(2, &list);
  CloseHost(&unobserved);
  for (int i = 0; i < 20; ++i) {
    struct Host stepping = OpenHost(8, &list);
    ActAll(&stepping, 7);
    CloseHost(&stepping);
  }
}

// Python programs may exit without closing their environments. Global objects must outlive the
// running step.
void ProcessMayEndWithoutClose(void) {
  static struct Host hosts[4];
  struct OptionList list = RequiredOptions("coinrun,maze");
  for (int i = 0; i < 4; ++i) {
    hosts[i] = OpenHost(64, &list);
    ActAll(&hosts[i], 7);
  }
}

enum { kHostThreadCount = 6 };

// Plays with its own handle; replaces its argument, the seed, by the digest.
static void* PlayAlone(void* seed_and_digest) {
  uint32_t* value = seed_and_digest;
  struct OptionList list = RequiredOptions("coinrun");
  AddInteger(&list, "rand_seed", (int32_t)*value);
  AddInteger(&list, "num_threads", (int32_t)(*value % 3));
  struct Host host = OpenHost(3, &list);
  *value = kDigestBegin;
  for (int step = 0; step < 80; ++step) {
    ActAll(&host, (step * 4) % 15);
    libenv.observe(host.handle);
    const uint32_t now = DigestOfHost(&host);
    *value = Digest(*value, &now, sizeof(now));
  }
  CloseHost(&host);
  return NULL;
}

void HandlesCanBeUsedByDifferentThreads(void) {
  uint32_t alone[kHostThreadCount];
  uint32_t together[kHostThreadCount];
  for (uint32_t i = 0; i < kHostThreadCount; ++i) {
    alone[i] = together[i] = i;
    PlayAlone(&alone[i]);
  }
  pthread_t threads[kHostThreadCount];
  for (int i = 0; i < kHostThreadCount; ++i) {
    CLAIM(pthread_create(&threads[i], NULL, PlayAlone, &together[i]) == 0);
  }
  for (int i = 0; i < kHostThreadCount; ++i) {
    pthread_join(threads[i], NULL);
    CLAIM(together[i] == alone[i]);
  }
}

static int CountEntries(const char* path) {
  DIR* folder = opendir(path);
  CLAIM(folder != NULL);
  int count = 0;
  while (readdir(folder) != NULL) {
    ++count;
  }
  closedir(folder);
  return count;
}

static long ResidentPages(void) {
  FILE* file = fopen("/proc/self/statm", "r");
  CLAIM(file != NULL);
  long pages = 0;
  CLAIM(fscanf(file, "%*d %ld", &pages) == 1);
  fclose(file);
  return pages;
}

static void MakeAndClose(int count) {
  const struct OptionList list = RequiredOptions("coinrun,maze");
  for (int i = 0; i < count; ++i) {
    struct Host host = OpenHost(2, &list);
    ActAll(&host, 7);
    libenv.observe(host.handle);
    CloseHost(&host);
  }
}

// Waits up to 10 s.
static int FallsTo(const char* path, int count) {
  const struct timespec moment = {.tv_nsec = 50 * 1000 * 1000};
  for (int i = 0; i < 200 && CountEntries(path) > count; ++i) {
    nanosleep(&moment, NULL);
  }
  return CountEntries(path) <= count;
}

void ThousandHandlesLeakNothing(void) {
  static const char kDescriptors[] = "/proc/self/fd";
  static const char kThreads[] = "/proc/self/task";
  // Creates everything that is never freed: art.
  MakeAndClose(100);
  const int descriptors = CountEntries(kDescriptors);
  const int threads = CountEntries(kThreads);
  const long pages = ResidentPages();
  MakeAndClose(1000);
  printf("descriptors %d -> %d, threads %d -> %d, resident pages %ld -> %ld\n", descriptors,
         CountEntries(kDescriptors), threads, CountEntries(kThreads), pages, ResidentPages());
  fflush(stdout);
  CLAIM(FallsTo(kDescriptors, descriptors));
  CLAIM(FallsTo(kThreads, threads));
  CLAIM(ResidentPages() - pages <= kGrowthPagesMax);
}
