// All claims that libenv_test can be asked to check, by what they are about. A name is the claim.
#ifndef TESTS_CLIENTS_LIBENV_CLAIMS_H_
#define TESTS_CLIENTS_LIBENV_CLAIMS_H_

// The folder of the recordings that come with the code.
extern const char* golden_folder;

// Of what is made: make_claims.c.
void VersionIsOne(void);
void LayoutIsThatOfThePage(void);
void SpacesAreThoseOfThePage(void);
void RenderHumanAddsAnInfo(void);
void BadOptionsAreToldInOneLine(void);
void MalformedOptionsAreToldInOneLine(void);
void DefaultsAreTheLibrarys(void);
void AllOptionsAreTaken(void);

// Of what is observed: step_claims.c.
void FirstObservationNeedsNoStep(void);
void ObserveIsIdempotent(void);
void BuffersAreWrittenAtObserveOnly(void);
void ActionsAreTakenDuringActOnly(void);
void UnknownActionsDoNothing(void);
void ThreadsChangeNothing(void);
void JointGamesAreDealtInTurn(void);
void HumanViewIsDrawnAtEachObserve(void);
void RecordingsAreTheSame(void);
void UpstreamPicturesAreTheSame(void);

// Of snapshots: state_claims.c.
void RestoredEnvironmentsGoOnTheSame(void);
void RestoringRefreshesOneEnvironment(void);
void SnapshotsAreTakenBeforeBuffersAreSet(void);
void OptionsComeFromTheSnapshot(void);
void BadSnapshotsAreToldInOneLine(void);

// Of the art that is drawn with: art_claims.c.
void ArtOfTheFolderIsShown(void);
void FolderWithoutArtIsToldInOneLine(void);
void FolderIsReadOnceWhileAHandleUsesIt(void);
void FolderIsTheServersAffair(void);

// Of life and death: life_claims.c.
void MisuseIsToldInOneLine(void);
void CloseMayComeAtAnyTime(void);
void ProcessMayEndWithoutClose(void);
void HandlesMayBeUsedByThreadsOfTheirOwn(void);
void ThousandHandlesLeakNothing(void);
// These want no server, or lose theirs.
void UnreachableServerIsToldInOneLine(void);
void HostThatDiesLeavesNothing(void);
void LostServerIsToldOnce(void);

#endif  // TESTS_CLIENTS_LIBENV_CLAIMS_H_
