// The claims that libenv_test can check, by subject. A name is the claim.
#ifndef TESTS_CLIENTS_LIBENV_CLAIMS_H_
#define TESTS_CLIENTS_LIBENV_CLAIMS_H_

// The folder of the recordings in this repository.
extern const char* golden_folder;

// Creation: make_claims.c.
void VersionIsOne(void);
void LayoutMatchesTheDocumentation(void);
void SpacesMatchTheDocumentation(void);
void RenderHumanAddsAnInfo(void);
void InvalidOptionErrorIsOneLine(void);
void MalformedOptionErrorIsOneLine(void);
void MissingOptionsHaveTheDefaults(void);
void AllOptionsAreAccepted(void);

// Steps and observations: step_claims.c.
void FirstObservationNeedsNoStep(void);
void ObserveIsIdempotent(void);
void BuffersAreWrittenAtObserveOnly(void);
void ActionsAreReadDuringActOnly(void);
void UnknownActionsDoNothing(void);
void ThreadsChangeNothing(void);
void SeveralGamesAreAssignedRoundRobin(void);
void HumanViewIsDrawnAtEachObserve(void);
void GoldenRecordingsReplayIdentically(void);
void UpstreamObservationsReplayIdentically(void);

// Snapshots: state_claims.c.
void RestoredEnvironmentsContinueIdentically(void);
void RestoringRefreshesOneEnvironment(void);
void SnapshotsNeedNoBuffers(void);
void OptionsComeFromTheSnapshot(void);
void InvalidSnapshotErrorIsOneLine(void);

// Art: art_claims.c.
void FolderArtIsDrawn(void);
void FolderWithoutArtErrorIsOneLine(void);
void FolderIsReadOnceWhileAHandleUsesIt(void);

// Lifetime and errors: life_claims.c.
void MisuseErrorIsOneLine(void);
void CloseIsAllowedAtAnyTime(void);
void ProcessMayEndWithoutClose(void);
void HandlesCanBeUsedByDifferentThreads(void);
void ThousandHandlesLeakNothing(void);

#endif  // TESTS_CLIENTS_LIBENV_CLAIMS_H_
