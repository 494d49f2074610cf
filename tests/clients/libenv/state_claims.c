#include <stdlib.h>
#include <string.h>

#include "tests/clients/libenv/claim.h"
#include "tests/clients/libenv/claims.h"
#include "tests/clients/libenv/host.h"
#include "tests/clients/libenv/standard_error.h"

enum { kSnapshotBytesMax = 1 << 20 };  // what the Python package offers

static char snapshot[kSnapshotBytesMax];

static const char* const kGames =
    "bigfish,bossfight,caveflyer,chaser,climber,coinrun,dodgeball,fruitbot,"
    "heist,jumper,leaper,maze,miner,ninja,plunder,starpilot";
enum { kGameCount = 16 };

static void Play(struct Host* host, int first_step, int step_count) {
  for (int step = first_step; step < first_step + step_count; ++step) {
    for (int i = 0; i < host->env_count; ++i) {
      *host->actions[i] = (step * 7 + i * 3) % 15;
    }
    libenv.act(host->handle);
    libenv.observe(host->handle);
  }
}

static uint32_t DigestOfPlay(struct Host* host, int first_step, int step_count) {
  uint32_t digest = kDigestBegin;
  for (int step = 0; step < step_count; ++step) {
    Play(host, first_step + step, 1);
    const uint32_t now = DigestOfHost(host);
    digest = Digest(digest, &now, sizeof(now));
  }
  return digest;
}

void RestoredEnvironmentsContinueIdentically(void) {
  const struct OptionList list = RequiredOptions(kGames);
  struct OptionList other_list = RequiredOptions(kGames);
  AddInteger(&other_list, "rand_seed", 77);
  AddInteger(&other_list, "num_threads", 0);
  struct Host host = OpenHost(kGameCount, &list);
  struct Host other = OpenHost(kGameCount, &other_list);
  libenv.observe(host.handle);
  libenv.observe(other.handle);
  Play(&host, 0, 60);
  Play(&other, 50, 10);
  for (int i = 0; i < kGameCount; ++i) {
    const int size = libenv.get_state(host.handle, i, snapshot, kSnapshotBytesMax);
    CLAIM(size > 0);
    libenv.set_state(other.handle, i, snapshot, size);
  }
  CLAIM(DigestOfHost(&other) == DigestOfHost(&host));
  CLAIM(DigestOfPlay(&other, 60, 120) == DigestOfPlay(&host, 60, 120));
  CloseHost(&host);
  CloseHost(&other);
}

void RestoringRefreshesOneEnvironment(void) {
  struct OptionList list = RequiredOptions("coinrun");
  AddBoolean(&list, "render_human", 1);
  struct Host host = OpenHost(3, &list);
  libenv.observe(host.handle);
  Play(&host, 0, 20);
  const int size = libenv.get_state(host.handle, 1, snapshot, kSnapshotBytesMax);
  CLAIM(size > 0);
  static uint8_t picture[kPictureBytes];
  static uint8_t human_view[kHumanViewBytes];
  memcpy(picture, host.pictures[1], kPictureBytes);
  memcpy(human_view, host.human_views[1], kHumanViewBytes);
  const int32_t level_seed = *host.level_seeds[1];
  ActAll(&host, -1);
  libenv.observe(host.handle);
  CLAIM(host.firsts[1] == 1 && memcmp(picture, host.pictures[1], kPictureBytes) != 0);
  host.rewards[0] = 99.0F;
  *host.level_seeds[2] = -1;
  libenv.set_state(host.handle, 1, snapshot, size);
  CLAIM(memcmp(picture, host.pictures[1], kPictureBytes) == 0);
  CLAIM(memcmp(human_view, host.human_views[1], kHumanViewBytes) == 0);
  CLAIM(host.firsts[1] == 0 && *host.level_seeds[1] == level_seed);
  CLAIM(host.rewards[0] == 99.0F && *host.level_seeds[2] == -1);
  CloseHost(&host);
}

void SnapshotsNeedNoBuffers(void) {
  const struct OptionList list = RequiredOptions("maze");
  struct LibenvHandle* handle = Make(1, &list);
  struct Host host = OpenHost(1, &list);
  ActAll(&host, -1);
  libenv.observe(host.handle);
  const uint32_t expected = DigestOfHost(&host);
  // libenv_get_state waits for the running step.
  ActAll(&host, -1);
  const int later = libenv.get_state(host.handle, 0, snapshot, kSnapshotBytesMax);
  CLAIM(later > 0);
  libenv.set_state(handle, 0, snapshot, later);
  const int again = libenv.get_state(handle, 0, snapshot + later, kSnapshotBytesMax - later);
  CLAIM(again == later && memcmp(snapshot, snapshot + later, (size_t)later) == 0);
  CLAIM(DigestOfHost(&host) == expected);  // nothing was observed meanwhile
  libenv.close(handle);
  CloseHost(&host);
}

void OptionsComeFromTheSnapshot(void) {
  const struct OptionList easy_list = RequiredOptions("maze");
  struct OptionList hard_list = RequiredOptions("maze");
  AddInteger(&hard_list, "distribution_mode", 1);
  AddInteger(&hard_list, "num_levels", 1);
  struct Host easy = OpenHost(1, &easy_list);
  struct Host hard = OpenHost(1, &hard_list);
  libenv.observe(easy.handle);
  libenv.observe(hard.handle);
  const int size = libenv.get_state(hard.handle, 0, snapshot, kSnapshotBytesMax);
  libenv.set_state(easy.handle, 0, snapshot, size);
  for (int episode = 0; episode < 5; ++episode) {
    CLAIM(*easy.level_seeds[0] == 0);
    CLAIM(memcmp(easy.pictures[0], hard.pictures[0], kPictureBytes) == 0);
    ActAll(&easy, -1);
    ActAll(&hard, -1);
    libenv.observe(easy.handle);
    libenv.observe(hard.handle);
  }
  CloseHost(&easy);
  CloseHost(&hard);
}

// Expects that libenv_set_state writes one line that contains `expected`, and changes nothing.
static void ClaimRejected(struct Host* host, int environment, char* data, int length,
                          const char* expected) {
  const uint32_t before = DigestOfHost(host);
  BeginListening();
  libenv.set_state(host->handle, environment, data, length);
  const struct CapturedOutput said = EndListening();
  CLAIM(said.line_count == 1 && strstr(said.text, expected) != NULL);
  CLAIM(DigestOfHost(host) == before);
  libenv.observe(host->handle);
  CLAIM(DigestOfHost(host) == before);
}

void InvalidSnapshotErrorIsOneLine(void) {
  const struct OptionList list = RequiredOptions("coinrun,maze");
  struct Host host = OpenHost(2, &list);
  libenv.observe(host.handle);
  const int size = libenv.get_state(host.handle, 0, snapshot, kSnapshotBytesMax);
  CLAIM(size > 0);

  ClaimRejected(&host, 2, snapshot, size, "environment 2 is not in [0, 2)");
  ClaimRejected(&host, -1, snapshot, size, "environment -1 is not in [0, 2)");
  ClaimRejected(&host, 1, snapshot, size, "coinrun");
  ClaimRejected(&host, 0, snapshot, size - 1, "snapshot");
  ClaimRejected(&host, 0, snapshot, 0, "snapshot");
  ClaimRejected(&host, 0, snapshot, -5, "snapshot");
  ClaimRejected(&host, 0, NULL, size, "snapshot");
  snapshot[size / 2] ^= 1;
  ClaimRejected(&host, 0, snapshot, size, "snapshot");

  char small[64] = "as it was";
  BeginListening();
  CLAIM(libenv.get_state(host.handle, 0, small, sizeof(small)) == 0);
  struct CapturedOutput said = EndListening();
  CLAIM(said.line_count == 1 && strstr(said.text, "the buffer has 64") != NULL);
  CLAIM(strcmp(small, "as it was") == 0);
  BeginListening();
  CLAIM(libenv.get_state(host.handle, 2, snapshot, kSnapshotBytesMax) == 0);
  said = EndListening();
  CLAIM(said.line_count == 1 && strstr(said.text, "environment 2 is not in [0, 2)") != NULL);
  CloseHost(&host);
}
