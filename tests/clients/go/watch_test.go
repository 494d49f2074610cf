package procgenclient

// Watching pools, and reading their episodes.

import (
	"bytes"
	"context"
	"errors"
	"io"
	"reflect"
	"testing"

	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

const observationBytes = 64 * 64 * 3

func TestPoolIsWatchedWhileItIsStepped(t *testing.T) {
	pool := madePool(t, connected(t, Options{}), easy(4, "maze"), PoolOptions{})
	var batch *Batch
	var frames []*pb.Frame
	options := WatchOptions{Environments: []int32{3, 0}, SizePx: 64, FramesPerSecondMax: 60}
	must(t, pool.Watch(testContext(t), options, func(moment *pb.WatchPoolResponse) bool {
		if frames = moment.Frames; moment.SequenceNumber == 0 {
			batch = stepped(t, pool, []int32{7, 4, 5, 1}, StepOptions{})
		}
		return moment.SequenceNumber < 1
	}))
	for i, environment := range options.Environments {
		if frame := frames[i]; frame.Environment != environment || frame.SizePx != 64 {
			t.Error(frame.Environment, frame.SizePx)
		}
		observed := batch.Observations[int(environment)*observationBytes:][:observationBytes]
		if !bytes.Equal(frames[i].Image, observed) {
			t.Errorf("the frame of environment %d differs from its observation", environment)
		}
	}
}

func TestFirst16EnvironmentsAreWatchedByDefault(t *testing.T) {
	pool := madePool(t, connected(t, Options{}), easy(17, "maze"), PoolOptions{})
	var frames []*pb.Frame
	must(t, pool.Watch(testContext(t), WatchOptions{}, func(moment *pb.WatchPoolResponse) bool {
		frames = moment.Frames
		return false
	}))
	if len(frames) != 16 {
		t.Fatal(len(frames), "frames")
	}
	for i, frame := range frames {
		if frame.Environment != int32(i) || len(frame.Image) != 256*256*3 {
			t.Error(i, frame.Environment, len(frame.Image))
		}
	}
}

func TestSlowWatcherSkipsFrameSets(t *testing.T) {
	const steps = 20
	pool := madePool(t, connected(t, Options{}), easy(1, "bigfish"), PoolOptions{})
	options := WatchOptions{SizePx: 64, FramesPerSecondMax: 60}
	isLong := make(chan struct{})
	quickIsThere := make(chan struct{})
	seen := make(chan int)
	go func() {
		count := 0
		if err := pool.Watch(testContext(t), options, func(moment *pb.WatchPoolResponse) bool {
			if count++; count == 1 {
				close(isLong)
				<-quickIsThere
			}
			return moment.SequenceNumber < steps
		}); err != nil {
			t.Error(err)
		}
		seen <- count
	}()
	<-isLong
	must(t, pool.Watch(testContext(t), options, func(moment *pb.WatchPoolResponse) bool {
		if moment.SequenceNumber < steps {
			stepped(t, pool, []int32{4}, StepOptions{})
		}
		return moment.SequenceNumber < steps
	}))
	close(quickIsThere)
	if count := <-seen; count > steps/2 {
		t.Errorf("%d frame sets of %d steps were queued", count, steps)
	}
}

func TestFrameSizesAreLimitedByTheServer(t *testing.T) {
	small, err := StartServer("", "--workers=1", "--response_bytes_max=1048576")
	must(t, err)
	client, err := Connect(testContext(t), small.Address, Options{})
	must(t, err)
	pool := madePool(t, client, easy(7, "maze"), PoolOptions{})
	frames, err := pool.Render(testContext(t), 512)
	must(t, err)
	if len(frames) != 7 {
		t.Error(len(frames), "frames")
	}
	four := WatchOptions{Environments: []int32{0, 1, 2, 3}}
	must(t, pool.Watch(testContext(t), four, func(moment *pb.WatchPoolResponse) bool { return false }))
	err = pool.Watch(testContext(t), WatchOptions{}, func(*pb.WatchPoolResponse) bool { return false })
	expectError(t, err, codes.ResourceExhausted, "has room for 5 frames of 256 x 256 pixels")
	must(t, client.Close())
	must(t, small.Stop())
}

func TestFramesBeyondTheDefaultMessageSizeAreReceived(t *testing.T) {
	pool := madePool(t, connected(t, Options{}), easy(16, "maze"), PoolOptions{})
	count := 0
	must(t, pool.Watch(testContext(t), WatchOptions{SizePx: 512}, func(moment *pb.WatchPoolResponse) bool {
		count = len(moment.Frames)
		return false
	}))
	if count != 16 {
		t.Error(count, "frames")
	}
}

func TestWatchEndsWithAnError(t *testing.T) {
	client := connected(t, Options{})
	pool := madePool(t, client, easy(1, "maze"), PoolOptions{})
	unseen := func(*pb.WatchPoolResponse) bool {
		t.Error("received a frame set")
		return true
	}
	err := pool.Watch(testContext(t), WatchOptions{Environments: []int32{1}}, unseen)
	expectError(t, err, codes.InvalidArgument, "environments")
	err = pool.Watch(testContext(t), WatchOptions{FramesPerSecondMax: 61}, unseen)
	expectError(t, err, codes.InvalidArgument, "frames_per_second_max")
	err = pool.Watch(testContext(t), WatchOptions{SizePx: 8}, unseen)
	expectError(t, err, codes.InvalidArgument, "size_px")
	err = pool.Watch(testContext(t), WatchOptions{}, func(*pb.WatchPoolResponse) bool {
		must(t, client.DeletePool(testContext(t), pool.Name()))
		return true
	})
	expectError(t, err, codes.Aborted)
	expectError(t, pool.Watch(testContext(t), WatchOptions{}, unseen), codes.NotFound)
}

func TestServerThatEndsTheStreamIsUnavailable(t *testing.T) {
	ends := func() (int, error) { return 0, io.EOF }
	err := watch(testContext(t), ends, func(int) bool { return true })
	expectError(t, err, codes.Unavailable, "ended the stream")
}

func TestContextEndsAWatch(t *testing.T) {
	pool := madePool(t, connected(t, Options{}), easy(1, "maze"), PoolOptions{})
	ctx, cancel := context.WithCancel(testContext(t))
	err := pool.Watch(ctx, WatchOptions{}, func(*pb.WatchPoolResponse) bool {
		cancel()
		return true
	})
	expectError(t, err, codes.Canceled)
	if !errors.Is(err, context.Canceled) {
		t.Error(err)
	}
}

func TestEpisodeIsFoundAndReplayed(t *testing.T) {
	ctx := testContext(t)
	client := connected(t, Options{})
	pool := madePool(t, client, easy(2, "coinrun"), PoolOptions{})
	_, err := pool.GetEpisode(ctx, 1, pb.EpisodeSelector_EPISODE_SELECTOR_LAST)
	expectError(t, err, codes.FailedPrecondition)
	actions := []int32{7, 8, 7, -1}
	rewards := []float32{}
	var fingerprints []uint64
	for _, action := range actions {
		batch := stepped(t, pool, []int32{4, action}, StepOptions{})
		rewards = append(rewards, batch.Rewards[1])
		fingerprints = batch.Fingerprints
	}
	episode, err := pool.GetEpisode(ctx, 1, pb.EpisodeSelector_EPISODE_SELECTOR_LAST)
	must(t, err)
	if !bytes.Equal(episode.Actions, []byte{7, 8, 7, 255}) || !reflect.DeepEqual(episode.Rewards, rewards) {
		t.Error(episode)
	}
	if episode.Outcome != pb.EpisodeOutcome_EPISODE_OUTCOME_TERMINATED {
		t.Error(episode.Outcome)
	}
	if !reflect.DeepEqual(fingerprints, []uint64{uint64(episode.Fingerprint)}) {
		t.Error(fingerprints, episode.Fingerprint)
	}
	current, err := pool.GetEpisode(ctx, 0, pb.EpisodeSelector_EPISODE_SELECTOR_CURRENT)
	must(t, err)
	if !bytes.Equal(current.Actions, []byte{4, 4, 4, 4}) {
		t.Error(current.Actions)
	}
	_, err = pool.GetEpisode(ctx, 2, pb.EpisodeSelector_EPISODE_SELECTOR_LAST)
	expectError(t, err, codes.InvalidArgument, "environment")
	stepped(t, pool, []int32{4, -1}, StepOptions{})
	found, err := pool.FindEpisode(ctx, 1, fingerprints[0])
	must(t, err)
	if !bytes.Equal(found.Actions, episode.Actions) || found.Fingerprint != episode.Fingerprint {
		t.Error(found, episode)
	}
	_, err = pool.FindEpisode(ctx, 0, fingerprints[0])
	expectError(t, err, codes.NotFound)

	spec := &pb.PoolSpec{Games: []string{episode.Game}, EnvCount: 1, Options: episode.Options}
	again := madePool(t, client, spec, PoolOptions{})
	for i, action := range actions {
		batch := stepped(t, again, []int32{action}, StepOptions{})
		if batch.Rewards[0] != rewards[i] {
			t.Errorf("reward %d is %v, and was %v", i, batch.Rewards[0], rewards[i])
		}
		if i == len(actions)-1 && !reflect.DeepEqual(batch.Fingerprints, fingerprints) {
			t.Error(batch.Fingerprints, fingerprints)
		}
	}
}
