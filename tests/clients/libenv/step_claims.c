#include <dirent.h>
#include <string.h>
#include <unistd.h>

#include "tests/clients/libenv/claim.h"
#include "tests/clients/libenv/claims.h"
#include "tests/clients/libenv/host.h"
#include "tests/clients/libenv/recording.h"
#include "tests/clients/libenv/standard_error.h"

static uint32_t ObserveDigest(struct Host* host) {
  libenv.observe(host->handle);
  return DigestOfHost(host);
}

void FirstObservationNeedsNoStep(void) {
  struct OptionList list = RequiredOptions("coinrun");
  AddInteger(&list, "num_levels", 3);
  list.integers[2] = 70;  // start_level
  struct Host host = OpenHost(4, &list);
  libenv.observe(host.handle);
  for (int i = 0; i < 4; ++i) {
    CLAIM(host.firsts[i] == 1 && host.rewards[i] == 0.0F);
    CLAIM(*host.prev_level_seeds[i] == 0 && *host.prev_level_complete[i] == 0);
    CLAIM(*host.level_seeds[i] >= 70 && *host.level_seeds[i] < 73);
    int lit = 0;
    for (int k = 0; k < kPictureBytes; ++k) {
      lit += host.pictures[i][k] != 0x5a;
    }
    CLAIM(lit > kPictureBytes / 2);
  }
  CloseHost(&host);
}

void ObserveIsIdempotent(void) {
  struct OptionList list = RequiredOptions("coinrun");
  struct Host host = OpenHost(3, &list);
  for (int step = 0; step < 10; ++step) {
    const uint32_t expected = ObserveDigest(&host);
    memset(host.pictures[1], 1, kPictureBytes);
    host.rewards[0] = 99.0F;
    host.firsts[2] = 9;
    *host.level_seeds[2] = -1;
    CLAIM(ObserveDigest(&host) == expected);
    CLAIM(ObserveDigest(&host) == expected);
    ActAll(&host, step == 4 ? -1 : 7);
  }
  CloseHost(&host);
}

void BuffersAreWrittenAtObserveOnly(void) {
  struct OptionList list = RequiredOptions("coinrun");
  AddInteger(&list, "num_threads", 0);
  struct Host host = OpenHost(2, &list);
  const uint32_t before = ObserveDigest(&host);
  ActAll(&host, 7);
  ActAll(&host, -1);
  CLAIM(DigestOfHost(&host) == before);
  CLAIM(ObserveDigest(&host) != before);
  CLAIM(host.firsts[0] == 1 && host.firsts[1] == 1);
  CloseHost(&host);
}

void ActionsAreReadDuringActOnly(void) {
  const struct OptionList list = RequiredOptions("starpilot");
  struct Host one = OpenHost(2, &list);
  struct Host other = OpenHost(2, &list);
  for (int step = 0; step < 30; ++step) {
    ActAll(&one, step % 15);
    ActAll(&other, step % 15);
    *other.actions[0] = -1;
    *other.actions[1] = 1 << 30;
    CLAIM(ObserveDigest(&one) == ObserveDigest(&other));
  }
  CloseHost(&one);
  CloseHost(&other);
}

void UnknownActionsDoNothing(void) {
  static const int32_t kUnknown[] = {15, -2, 255, INT32_MAX, INT32_MIN, 16, -3};
  const struct OptionList list = RequiredOptions("coinrun");
  struct Host one = OpenHost(2, &list);
  struct Host other = OpenHost(2, &list);
  BeginListening();
  for (size_t step = 0; step < sizeof(kUnknown) / sizeof(*kUnknown); ++step) {
    ActAll(&one, kUnknown[step]);
    ActAll(&other, 4);
    CLAIM(ObserveDigest(&one) == ObserveDigest(&other));
  }
  const struct CapturedOutput said = EndListening();
  CLAIM(said.line_count == 1 && strstr(said.text, "action 15 of environment 0") != NULL);
  CloseHost(&one);
  CloseHost(&other);
}

void ThreadsChangeNothing(void) {
  static const int32_t kThreadCounts[] = {0, 1, 3, 64};
  uint32_t expected = 0;
  for (size_t i = 0; i < sizeof(kThreadCounts) / sizeof(*kThreadCounts); ++i) {
    struct OptionList list = RequiredOptions("bigfish");
    AddInteger(&list, "num_threads", kThreadCounts[i]);
    struct Host host = OpenHost(7, &list);
    uint32_t digest = kDigestBegin;
    for (int step = 0; step < 60; ++step) {
      ActAll(&host, (step * 7) % 15);
      const uint32_t now = ObserveDigest(&host);
      digest = Digest(digest, &now, sizeof(now));
    }
    CloseHost(&host);
    CLAIM(i == 0 || digest == expected);
    expected = digest;
  }
}

void SeveralGamesAreAssignedRoundRobin(void) {
  const struct OptionList joint_list = RequiredOptions("coinrun,maze");
  const struct OptionList maze_list = RequiredOptions("maze");
  struct Host joint = OpenHost(4, &joint_list);
  struct Host maze = OpenHost(4, &maze_list);
  libenv.observe(joint.handle);
  libenv.observe(maze.handle);
  for (int i = 0; i < 4; ++i) {
    const int same = memcmp(joint.pictures[i], maze.pictures[i], kPictureBytes) == 0;
    CLAIM(same == (i % 2 == 1));
    CLAIM(*joint.level_seeds[i] == *maze.level_seeds[i]);
  }
  CloseHost(&joint);
  CloseHost(&maze);
}

void HumanViewIsDrawnAtEachObserve(void) {
  struct OptionList list = RequiredOptions("starpilot");
  AddBoolean(&list, "render_human", 1);
  struct Host host = OpenHost(2, &list);
  const uint32_t first = ObserveDigest(&host);
  const uint32_t view = Digest(kDigestBegin, host.human_views[1], kHumanViewBytes);
  memset(host.human_views[1], 0, kHumanViewBytes);
  CLAIM(ObserveDigest(&host) == first);
  CLAIM(memcmp(host.human_views[0], host.human_views[1], kHumanViewBytes) != 0);
  ActAll(&host, 7);
  libenv.observe(host.handle);
  CLAIM(Digest(kDigestBegin, host.human_views[1], kHumanViewBytes) != view);
  CloseHost(&host);
}

static void ClaimRow(const struct Recording* recording, int row, int with_pictures,
                     struct Host* host) {
  for (int i = 0; i < recording->env_count; ++i) {
    const int at = row * recording->env_count + i;
    CLAIM(memcmp(&host->rewards[i], &recording->rewards[at], sizeof(float)) == 0);
    CLAIM(host->firsts[i] == recording->firsts[at]);
    CLAIM(*host->level_seeds[i] == recording->level_seeds[at]);
    CLAIM(*host->prev_level_seeds[i] == recording->prev_level_seeds[at]);
    CLAIM(*host->prev_level_complete[i] == recording->prev_level_complete[at]);
    CLAIM(!with_pictures ||
          recording->picture_digests[at] == Digest(kDigestBegin, host->pictures[i], kPictureBytes));
  }
}

// `art_dir`: the folder of Procgen 0.10.7's art with a trailing slash; null for the built-in art.
static void Replay(const char* path, const char* art_dir) {
  struct Recording recording;
  ReadRecording(path, &recording);
  if (art_dir != NULL) {
    AddString(&recording.options, "resource_root", art_dir);
  }
  const int with_pictures =
      recording.picture_digests != NULL && (art_dir != NULL || !recording.has_upstream_art);
  struct Host host = OpenHost(recording.env_count, &recording.options);
  libenv.observe(host.handle);
  ClaimRow(&recording, 0, with_pictures, &host);
  for (int step = 0; step < recording.step_count; ++step) {
    for (int i = 0; i < recording.env_count; ++i) {
      const uint8_t action = recording.actions[step * recording.env_count + i];
      *host.actions[i] = action == 255 ? -1 : action;
    }
    libenv.act(host.handle);
    libenv.observe(host.handle);
    ClaimRow(&recording, step + 1, with_pictures, &host);
  }
  CloseHost(&host);
  FreeRecording(&recording);
}

// Replays all recordings of a folder and returns how many there are.
static int ReplayFolder(const char* recordings_folder, const char* art_dir) {
  DIR* folder = opendir(recordings_folder);
  CLAIM(folder != NULL);
  int count = 0;
  for (const struct dirent* entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
    const char* suffix = strstr(entry->d_name, ".trace");
    if (suffix != NULL && suffix[6] == '\0') {
      char path[4096];
      snprintf(path, sizeof(path), "%s/%s", recordings_folder, entry->d_name);
      printf("%s\n", entry->d_name);
      fflush(stdout);
      Replay(path, art_dir);
      ++count;
    }
  }
  closedir(folder);
  return count;
}

void GoldenRecordingsReplayIdentically(void) { CLAIM(ReplayFolder(golden_folder, NULL) >= 20); }

void UpstreamObservationsReplayIdentically(void) {
  const char* art_dir = getenv("PROCGEN_UPSTREAM_ART_DIR");
  const char* recordings_folder = getenv("PROCGEN_UPSTREAM_PICTURES");
  CLAIM(art_dir != NULL && recordings_folder != NULL);
  if (access(art_dir, R_OK) != 0 || access(recordings_folder, R_OK) != 0) {
    printf("skipped: no upstream art or no recordings of it next to the checkout\n");
    exit(kSkipped);
  }
  // Keeps the art loaded during all replays: loading takes longer than a replay.
  struct OptionList options = RequiredOptions("coinrun");
  AddString(&options, "resource_root", art_dir);
  struct Host first = OpenHost(1, &options);
  CLAIM(ReplayFolder(recordings_folder, art_dir) > 0);
  CloseHost(&first);
}
