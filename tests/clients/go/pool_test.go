package procgenclient

// Pools on a real server: batches, slices, pipelined requests, errors, cancelled waits.

import (
	"bytes"
	"context"
	"errors"
	"reflect"
	"testing"

	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

func TestNewPoolHasFirstObservations(t *testing.T) {
	pool := madePool(t, connected(t, Options{}), easy(3, "maze"), PoolOptions{})
	batch, err := pool.Observe(testContext(t), Slice{})
	must(t, err)
	if batch.SequenceNumber != 1 || batch.EnvCount() != 3 || len(batch.Observations) != 3*12288 {
		t.Error(batch.SequenceNumber, batch.EnvCount(), len(batch.Observations))
	}
	if !reflect.DeepEqual(batch.First, []bool{true, true, true}) || !reflect.DeepEqual(batch.Rewards, []float32{0, 0, 0}) {
		t.Error(batch.First, batch.Rewards)
	}
	if bytes.Equal(batch.Observation(0), batch.Observation(1)) {
		t.Error("two levels look alike")
	}
}

func TestBatchesAreEqualWithAnyPipeliningAndChunking(t *testing.T) {
	client := connected(t, Options{})
	plain := madePool(t, client, easy(8, "maze", "bigfish"), PoolOptions{})
	ahead := madePool(t, client, easy(8, "maze", "bigfish"), PoolOptions{RequestsInFlightMax: 4, ChunkCount: 3})
	ended := 0
	for step := 0; step < 60; step += 2 {
		actions, more := actionsOf(step, 8), actionsOf(step+1, 8)
		first := stepped(t, plain, actions, StepOptions{})
		second := stepped(t, plain, more, StepOptions{})
		must(t, ahead.SendStep(testContext(t), actions[:4], StepOptions{EnvCount: 4}))
		must(t, ahead.SendStep(testContext(t), actions[4:], StepOptions{FirstEnv: 4}))
		must(t, ahead.SendStep(testContext(t), more, StepOptions{}))
		var halves [2]*Batch
		for i := range halves {
			var err error
			halves[i], err = ahead.Receive(testContext(t))
			must(t, err)
		}
		if !bytes.Equal(halves[1].Observations, first.Observations[4*12288:]) || halves[1].FirstEnv != 4 {
			t.Fatalf("the second half of step %d differs", step)
		}
		whole, err := ahead.Receive(testContext(t))
		must(t, err)
		whole.SequenceNumber = second.SequenceNumber
		if !reflect.DeepEqual(whole, second) {
			t.Fatalf("step %d differs", step+1)
		}
		ended += len(first.Fingerprints) + len(second.Fingerprints)
	}
	if ended == 0 {
		t.Error("no episode ended")
	}
}

func TestResponsesOfMoreThanFourMebibytesAreJoined(t *testing.T) {
	pool := madePool(t, connected(t, Options{}), easy(400, "coinrun"), PoolOptions{})
	batch := stepped(t, pool, make([]int32, 400), StepOptions{})
	if batch.EnvCount() != 400 || len(batch.Observations) != 400*12288 {
		t.Error(batch.EnvCount(), len(batch.Observations))
	}
}

func TestFormatsEndsResetsLevelsAndSamplersFollowTheProtocol(t *testing.T) {
	spec := easy(2, "maze")
	spec.AutoresetMode = pb.AutoresetMode_AUTORESET_MODE_DISABLED
	spec.ObservationFormat = &pb.ObservationFormat{
		Color: pb.Color_COLOR_GRAYSCALE, Layout: pb.Layout_LAYOUT_CHW, SizePx: 32, FrameStack: 2,
	}
	ctx := testContext(t)
	pool := madePool(t, connected(t, Options{}), spec, PoolOptions{})
	if !reflect.DeepEqual(pool.ObservationShape(), []int32{2, 1, 32, 32}) {
		t.Error(pool.ObservationShape())
	}
	ended := stepped(t, pool, []int32{-1, 4}, StepOptions{NextLevels: map[int32]int32{0: 42}})
	if !ended.Terminated[0] || ended.Terminated[1] {
		t.Error(ended.Terminated)
	}
	_, err := pool.Step(ctx, []int32{4, 4}, StepOptions{})
	expectError(t, err, codes.FailedPrecondition)
	begun := stepped(t, pool, []int32{4, 4}, StepOptions{Resets: []*pb.Reset{{Environment: 0}}})
	if !begun.First[0] || begun.First[1] || begun.LevelSeeds[0] != 42 {
		t.Error(begun.First, begun.LevelSeeds)
	}
	seed := int32(7)
	reset, err := pool.Reset(ctx, []*pb.Reset{{Environment: 1, LevelSeed: &seed}}, Slice{FirstEnv: 1})
	must(t, err)
	if !reflect.DeepEqual(reset.LevelSeeds, []int32{7}) {
		t.Error(reset.LevelSeeds)
	}
	must(t, pool.SetLevelSampler(ctx, &pb.LevelSampler{LevelSeeds: []int32{99}}))
	all, err := pool.Reset(ctx, nil, Slice{})
	must(t, err)
	if !reflect.DeepEqual(all.LevelSeeds, []int32{99, 99}) {
		t.Error(all.LevelSeeds)
	}
	blind := stepped(t, pool, []int32{4, 4}, StepOptions{Blind: true, RepeatCount: 5})
	if len(blind.Observations) != 0 || !reflect.DeepEqual(blind.EpisodeLengths, []int32{5, 5}) {
		t.Error(len(blind.Observations), blind.EpisodeLengths)
	}
}

func TestFinalObservationsAreReturnedOnRequest(t *testing.T) {
	pool := madePool(t, connected(t, Options{}), easy(3, "maze"), PoolOptions{})
	before, err := pool.Observe(testContext(t), Slice{})
	must(t, err)
	batch := stepped(t, pool, []int32{4, -1, 4}, StepOptions{FinalObservations: true})
	if len(batch.Fingerprints) != 1 || !bytes.Equal(batch.FinalObservations, before.Observation(1)) {
		t.Error(batch.Fingerprints, len(batch.FinalObservations))
	}
}

func TestInvalidArgumentsDoNotEndTheStream(t *testing.T) {
	ctx := testContext(t)
	pool := madePool(t, connected(t, Options{}), easy(2, "maze"), PoolOptions{})
	stepped(t, pool, []int32{4, 4}, StepOptions{})
	stream := pool.stream
	for words, try := range map[string]func() error{
		"actions[1] is 99, allowed: -1 to 14": func() error { return pool.SendStep(ctx, []int32{4, 99}, StepOptions{}) },
		"actions has 3 entries":               func() error { return pool.SendStep(ctx, []int32{4, 4, 4}, StepOptions{}) },
		"actions has 1 entries":               func() error { return pool.SendStep(ctx, []int32{4}, StepOptions{}) },
		"FirstEnv is 2": func() error {
			return pool.SendStep(ctx, []int32{4}, StepOptions{FirstEnv: 2})
		},
		"RepeatCount is 1001": func() error { return pool.SendStep(ctx, []int32{4, 4}, StepOptions{RepeatCount: 1001}) },
		"EnvCount is 3 from":  func() error { return pool.SendObserve(ctx, Slice{EnvCount: 3}) },
	} {
		expectError(t, try(), codes.InvalidArgument, words)
	}
	if pool.stream != stream || stepped(t, pool, []int32{4, 4}, StepOptions{}).SequenceNumber != 2 {
		t.Error("the stream was lost")
	}
}

func TestErrorOfTheServerEndsTheStreamAndLosesNothing(t *testing.T) {
	pool := madePool(t, connected(t, Options{}), easy(2, "maze"), PoolOptions{})
	stepped(t, pool, []int32{4, 4}, StepOptions{})
	_, err := pool.Step(testContext(t), []int32{4, 4}, StepOptions{Resets: []*pb.Reset{{Environment: 5}}})
	expectError(t, err, codes.InvalidArgument, "5")
	if number := stepped(t, pool, []int32{4, 4}, StepOptions{}).SequenceNumber; number != 2 {
		t.Error(number)
	}
}

func TestRequestsSentAheadAreBounded(t *testing.T) {
	ctx := testContext(t)
	pool := madePool(t, connected(t, Options{}), easy(1, "maze"), PoolOptions{})
	_, err := pool.Receive(ctx)
	expectError(t, err, codes.FailedPrecondition, "send first")
	must(t, pool.SendStep(ctx, []int32{4}, StepOptions{}))
	must(t, pool.SendStep(ctx, []int32{4}, StepOptions{}))
	expectError(t, pool.SendStep(ctx, []int32{4}, StepOptions{}), codes.FailedPrecondition, "at most 2: receive first")
	_, err = pool.Step(ctx, []int32{4}, StepOptions{})
	expectError(t, err, codes.FailedPrecondition, "receive them first")
}

func TestContextEndsTheWaitAndThePoolContinues(t *testing.T) {
	pool := madePool(t, connected(t, Options{}), easy(2, "maze"), PoolOptions{})
	ctx, cancel := context.WithCancel(context.Background())
	must(t, pool.SendStep(ctx, []int32{4, 4}, StepOptions{RepeatCount: 1000}))
	cancel()
	_, err := pool.Receive(ctx)
	expectError(t, err, codes.Canceled)
	if !errors.Is(err, context.Canceled) {
		t.Error(err)
	}
	if number := stepped(t, pool, []int32{4, 4}, StepOptions{}).SequenceNumber; number > 2 {
		t.Error(number)
	}
	_, err = pool.client.Load(ctx)
	expectError(t, err, codes.Canceled)
}

func TestPoolHasOneStreamThatAnotherCanTakeOver(t *testing.T) {
	ctx := testContext(t)
	client := connected(t, Options{})
	pool := madePool(t, client, easy(2, "maze"), PoolOptions{})
	stepped(t, pool, []int32{4, 4}, StepOptions{})
	other, err := client.GetPool(ctx, pool.Name(), PoolOptions{})
	must(t, err)
	_, err = other.Step(ctx, []int32{4, 4}, StepOptions{})
	expectError(t, err, codes.FailedPrecondition)
	must(t, other.Attach(ctx, AttachOptions{TakeOver: true}))
	stepped(t, other, []int32{4, 4}, StepOptions{})
	_, err = pool.Step(ctx, []int32{4, 4}, StepOptions{})
	expectError(t, err, codes.Aborted)
	other.Detach(ctx)
	if number := stepped(t, pool, []int32{4, 4}, StepOptions{}).SequenceNumber; number != 3 {
		t.Error(number)
	}
}

func TestRemovedEncodingIsRejected(t *testing.T) {
	client := connected(t, Options{})
	spec := &pb.PoolSpec{Games: []string{"maze"}, EnvCount: 1, Encoding: 3}
	_, err := client.CreatePool(testContext(t), "", spec, PoolOptions{})
	expectError(t, err, codes.InvalidArgument)
}
