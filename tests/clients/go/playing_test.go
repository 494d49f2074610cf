package procgenclient

// One pool of one game, in few lines.

import (
	"context"
	"testing"

	"google.golang.org/grpc/codes"
)

func TestPlayingStepsAPoolAndDeletesIt(t *testing.T) {
	playing := Play(testContext(t), server.Address, "maze", 3)
	if playing.Batch == nil || !playing.Batch.First[0] {
		t.Fatal(playing.err)
	}
	name := playing.pool.Name()
	seen := map[int32]bool{}
	for step := 0; step < 100 && playing.Step(playing.SampleActions()); step++ {
		for _, action := range playing.SampleActions() {
			seen[action] = true
		}
	}
	if playing.Batch.SequenceNumber != 101 || len(seen) != 15 || seen[-1] {
		t.Error(playing.Batch.SequenceNumber, seen)
	}
	must(t, playing.Close())
	_, err := connected(t, Options{}).GetPool(testContext(t), name, HoldOptions{})
	expectError(t, err, codes.NotFound)
}

func TestPlayingKeepsTheFirstError(t *testing.T) {
	none := Play(testContext(t), server.Address, "pong", 3)
	if none.Step(none.SampleActions()) {
		t.Error("stepped what is not there")
	}
	expectError(t, none.Close(), codes.NotFound, "pong")

	wrong := Play(testContext(t), server.Address, "maze", 3)
	if wrong.Step(make([]int32, 4)) || wrong.Step(wrong.SampleActions()) {
		t.Error("went on after an error")
	}
	expectError(t, wrong.Close(), codes.InvalidArgument, "4 actions")

	ctx, cancel := context.WithCancel(testContext(t))
	cancel()
	expectError(t, Play(ctx, server.Address, "maze", 3).Close(), codes.Canceled)
}
