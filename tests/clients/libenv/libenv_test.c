// Checks libenv.so from a C host's side, one claim a run:
//   libenv_test LIBENV GOLDEN_FOLDER CLAIM

#include <string.h>

#include "tests/clients/libenv/claim.h"
#include "tests/clients/libenv/claims.h"
#include "tests/clients/libenv/host.h"

const char* golden_folder = NULL;

static const struct {
  const char* name;
  void (*check)(void);
} kClaims[] = {
    {"version_is_one", VersionIsOne},
    {"layout_matches_the_documentation", LayoutMatchesTheDocumentation},
    {"spaces_match_the_documentation", SpacesMatchTheDocumentation},
    {"render_human_adds_an_info", RenderHumanAddsAnInfo},
    {"invalid_option_error_is_one_line", InvalidOptionErrorIsOneLine},
    {"malformed_option_error_is_one_line", MalformedOptionErrorIsOneLine},
    {"missing_options_have_the_defaults", MissingOptionsHaveTheDefaults},
    {"all_options_are_accepted", AllOptionsAreAccepted},
    {"first_observation_needs_no_step", FirstObservationNeedsNoStep},
    {"observe_is_idempotent", ObserveIsIdempotent},
    {"buffers_are_written_at_observe_only", BuffersAreWrittenAtObserveOnly},
    {"actions_are_read_during_act_only", ActionsAreReadDuringActOnly},
    {"unknown_actions_do_nothing", UnknownActionsDoNothing},
    {"threads_change_nothing", ThreadsChangeNothing},
    {"several_games_are_assigned_round_robin", SeveralGamesAreAssignedRoundRobin},
    {"human_view_is_drawn_at_each_observe", HumanViewIsDrawnAtEachObserve},
    {"golden_recordings_replay_identically", GoldenRecordingsReplayIdentically},
    {"upstream_observations_replay_identically", UpstreamObservationsReplayIdentically},
    {"folder_art_is_drawn", FolderArtIsDrawn},
    {"folder_without_art_error_is_one_line", FolderWithoutArtErrorIsOneLine},
    {"folder_is_read_once_while_a_handle_uses_it", FolderIsReadOnceWhileAHandleUsesIt},
    {"restored_environments_continue_identically", RestoredEnvironmentsContinueIdentically},
    {"restoring_refreshes_one_environment", RestoringRefreshesOneEnvironment},
    {"snapshots_need_no_buffers", SnapshotsNeedNoBuffers},
    {"options_come_from_the_snapshot", OptionsComeFromTheSnapshot},
    {"invalid_snapshot_error_is_one_line", InvalidSnapshotErrorIsOneLine},
    {"misuse_error_is_one_line", MisuseErrorIsOneLine},
    {"close_is_allowed_at_any_time", CloseIsAllowedAtAnyTime},
    {"process_may_end_without_close", ProcessMayEndWithoutClose},
    {"handles_can_be_used_by_different_threads", HandlesCanBeUsedByDifferentThreads},
    {"thousand_handles_leak_nothing", ThousandHandlesLeakNothing},
};

int main(int argument_count, char** arguments) {
  if (argument_count != 4) {
    printf("Usage: %s LIBENV GOLDEN_FOLDER CLAIM\n", arguments[0]);
    return 2;
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
