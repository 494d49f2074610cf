// Checks libenv.so from a C host's side, one claim a run:
//   libenv_test LIBENV GOLDEN_FOLDER CLAIM [SERVER]
// With SERVER, a procgen-server program, the environments are on such a server.

#include <string.h>

#include "tests/clients/libenv/claim.h"
#include "tests/clients/libenv/claims.h"
#include "tests/clients/libenv/host.h"
#include "tests/clients/libenv/server_process.h"

const char* golden_folder = NULL;

static const struct {
  const char* name;
  void (*check)(void);
} kClaims[] = {
    {"version_is_one", VersionIsOne},
    {"layout_is_that_of_the_page", LayoutIsThatOfThePage},
    {"spaces_are_those_of_the_page", SpacesAreThoseOfThePage},
    {"render_human_adds_an_info", RenderHumanAddsAnInfo},
    {"bad_options_are_told_in_one_line", BadOptionsAreToldInOneLine},
    {"malformed_options_are_told_in_one_line", MalformedOptionsAreToldInOneLine},
    {"defaults_are_the_librarys", DefaultsAreTheLibrarys},
    {"all_options_are_taken", AllOptionsAreTaken},
    {"first_observation_needs_no_step", FirstObservationNeedsNoStep},
    {"observe_is_idempotent", ObserveIsIdempotent},
    {"buffers_are_written_at_observe_only", BuffersAreWrittenAtObserveOnly},
    {"actions_are_taken_during_act_only", ActionsAreTakenDuringActOnly},
    {"unknown_actions_do_nothing", UnknownActionsDoNothing},
    {"threads_change_nothing", ThreadsChangeNothing},
    {"joint_games_are_dealt_in_turn", JointGamesAreDealtInTurn},
    {"human_view_is_drawn_at_each_observe", HumanViewIsDrawnAtEachObserve},
    {"recordings_are_the_same", RecordingsAreTheSame},
    {"upstream_pictures_are_the_same", UpstreamPicturesAreTheSame},
    {"art_of_the_folder_is_shown", ArtOfTheFolderIsShown},
    {"folder_without_art_is_told_in_one_line", FolderWithoutArtIsToldInOneLine},
    {"folder_is_read_once_while_a_handle_uses_it", FolderIsReadOnceWhileAHandleUsesIt},
    {"folder_is_the_servers_affair", FolderIsTheServersAffair},
    {"restored_environments_go_on_the_same", RestoredEnvironmentsGoOnTheSame},
    {"restoring_refreshes_one_environment", RestoringRefreshesOneEnvironment},
    {"snapshots_are_taken_before_buffers_are_set", SnapshotsAreTakenBeforeBuffersAreSet},
    {"options_come_from_the_snapshot", OptionsComeFromTheSnapshot},
    {"bad_snapshots_are_told_in_one_line", BadSnapshotsAreToldInOneLine},
    {"misuse_is_told_in_one_line", MisuseIsToldInOneLine},
    {"close_may_come_at_any_time", CloseMayComeAtAnyTime},
    {"process_may_end_without_close", ProcessMayEndWithoutClose},
    {"handles_may_be_used_by_threads_of_their_own", HandlesMayBeUsedByThreadsOfTheirOwn},
    {"thousand_handles_leak_nothing", ThousandHandlesLeakNothing},
    {"unreachable_server_is_told_in_one_line", UnreachableServerIsToldInOneLine},
    {"host_that_dies_leaves_nothing", HostThatDiesLeavesNothing},
    {"lost_server_is_told_once", LostServerIsToldOnce},
};

int main(int argument_count, char** arguments) {
  if (argument_count < 4 || argument_count > 5) {
    printf("Usage: %s LIBENV GOLDEN_FOLDER CLAIM [SERVER]\n", arguments[0]);
    return 2;
  }
  CLAIM(unsetenv("PROCGEN_SERVER") == 0);
  if (argument_count == 5) {
    StartServer(arguments[4]);
  }
  LoadInterface(arguments[1]);
  golden_folder = arguments[2];
  for (size_t i = 0; i < sizeof(kClaims) / sizeof(*kClaims); ++i) {
    if (strcmp(kClaims[i].name, arguments[3]) == 0) {
      kClaims[i].check();
      return EXIT_SUCCESS;
    }
  }
  printf("no claim is named %s\n", arguments[3]);
  return 2;
}
