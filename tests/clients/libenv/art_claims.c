#include <string.h>
#include <unistd.h>

#include "tests/clients/libenv/claim.h"
#include "tests/clients/libenv/claims.h"
#include "tests/clients/libenv/host.h"
#include "tests/clients/libenv/standard_error.h"

// Digests of the first steps of two environments: observations, and all other results.
struct Trajectory {
  uint32_t pictures;
  uint32_t facts;
  int line_count;  // of standard error
};

static struct Trajectory Play(const char* art_dir) {
  struct OptionList list = RequiredOptions("coinrun,starpilot");
  if (art_dir != NULL) {
    AddString(&list, "resource_root", art_dir);
  }
  BeginListening();
  struct Host host = OpenHost(2, &list);
  struct Trajectory trajectory = {kDigestBegin, kDigestBegin, 0};
  for (int step = 0; step < 40; ++step) {
    ActAll(&host, step % 15);
    libenv.observe(host.handle);
    for (int i = 0; i < host.env_count; ++i) {
      trajectory.pictures = Digest(trajectory.pictures, host.pictures[i], kPictureBytes);
      trajectory.facts = Digest(trajectory.facts, &host.rewards[i], sizeof(float));
      trajectory.facts = Digest(trajectory.facts, &host.firsts[i], 1);
      trajectory.facts = Digest(trajectory.facts, host.level_seeds[i], sizeof(int32_t));
    }
  }
  CloseHost(&host);
  trajectory.line_count = EndListening().line_count;
  return trajectory;
}

// A folder with art for all games. Claims that run concurrently share it, so none changes it.
static const char* PaintedFolder(void) {
  const char* folder = getenv("PROCGEN_PAINTED_ART_DIR");
  CLAIM(folder != NULL);
  return folder;
}

void FolderArtIsDrawn(void) {
  const struct Trajectory own = Play(NULL);
  const struct Trajectory painted = Play(PaintedFolder());
  CLAIM(own.line_count == 0 && painted.line_count == 0);
  CLAIM(painted.pictures != own.pictures);
  CLAIM(painted.facts == own.facts);
}

void FolderWithoutArtErrorIsOneLine(void) {
  const struct Trajectory own = Play(NULL);
  const struct Trajectory empty_name = Play("");
  CLAIM(empty_name.line_count == 0 && empty_name.pictures == own.pictures);
  static const char* const kFolders[] = {"/nowhere/at/all/", "/"};
  for (size_t i = 0; i < sizeof(kFolders) / sizeof(*kFolders); ++i) {
    struct OptionList list = RequiredOptions("coinrun");
    AddString(&list, "resource_root", kFolders[i]);
    BeginListening();
    struct LibenvHandle* handle = Make(1, &list);
    const struct CapturedOutput said = EndListening();
    CLAIM(handle != NULL);
    CLAIM(said.line_count == 1);
    CLAIM(strstr(said.text, "resource_root") != NULL && strstr(said.text, kFolders[i]) != NULL);
    libenv.close(handle);
    const struct Trajectory trajectory = Play(kFolders[i]);
    CLAIM(trajectory.pictures == own.pictures && trajectory.facts == own.facts);
  }
}

// Uses its own symbolic link to the folder, and removes it while the handle exists.
void FolderIsReadOnceWhileAHandleUsesIt(void) {
  char folder[] = "/tmp/libenv_test_XXXXXX";
  CLAIM(mkdtemp(folder) != NULL);
  char link[64];
  snprintf(link, sizeof(link), "%s/art", folder);
  CLAIM(symlink(PaintedFolder(), link) == 0);
  struct OptionList list = RequiredOptions("coinrun");
  AddString(&list, "resource_root", link);
  struct LibenvHandle* handle = Make(1, &list);
  CLAIM(handle != NULL);
  CLAIM(unlink(link) == 0 && rmdir(folder) == 0);
  const struct Trajectory shared = Play(link);
  CLAIM(shared.line_count == 0);
  CLAIM(shared.pictures == Play(PaintedFolder()).pictures);
  libenv.close(handle);
  CLAIM(Play(link).line_count == 1);
}
