package procgenclient

// VectorEnv: one pool of one game.

import (
	"context"
	"os"
	"testing"

	"google.golang.org/grpc/codes"
)

func TestVectorEnvStepsAPoolAndDeletesIt(t *testing.T) {
	env := NewVectorEnv(testContext(t), server.Address, "maze", 3)
	if env.Batch == nil || !env.Batch.First[0] {
		t.Fatal(env.err)
	}
	name := env.pool.Name()
	seen := map[int32]bool{}
	for step := 0; step < 100 && env.Step(env.SampleActions()); step++ {
		for _, action := range env.SampleActions() {
			seen[action] = true
		}
	}
	if env.Batch.SequenceNumber != 101 || len(seen) != 15 || seen[-1] {
		t.Error(env.Batch.SequenceNumber, seen)
	}
	must(t, env.Close())
	_, err := connected(t, Options{}).GetPool(testContext(t), name, PoolOptions{})
	expectError(t, err, codes.NotFound)
}

func TestVectorEnvKeepsTheFirstError(t *testing.T) {
	none := NewVectorEnv(testContext(t), server.Address, "pong", 3)
	if none.Step(none.SampleActions()) {
		t.Error("no error from an unknown game")
	}
	expectError(t, none.Close(), codes.NotFound, "pong")

	wrong := NewVectorEnv(testContext(t), server.Address, "maze", 3)
	if wrong.Step(make([]int32, 4)) || wrong.Step(wrong.SampleActions()) {
		t.Error("no error after the first one")
	}
	expectError(t, wrong.Close(), codes.InvalidArgument, "actions has 4 entries")

	ctx, cancel := context.WithCancel(testContext(t))
	cancel()
	expectError(t, NewVectorEnv(ctx, server.Address, "maze", 3).Close(), codes.Canceled)
}

func TestClosedVectorEnvLeavesTheNamesakeOfALostPool(t *testing.T) {
	folder, err := os.MkdirTemp("", "") // t.TempDir is too long for a socket's path.
	must(t, err)
	t.Cleanup(func() { _ = os.RemoveAll(folder) })
	address := "--address=unix:" + folder + "/socket"
	lost, err := StartServer("", address, "--workers=1")
	must(t, err)
	env := NewVectorEnv(testContext(t), lost.Address, "maze", 2)
	name := env.pool.Name()
	must(t, lost.Process.Kill())
	_, _ = lost.Process.Wait()
	again, err := StartServer("", address, "--workers=1")
	must(t, err)
	t.Cleanup(func() { _ = again.Stop() })
	for env.Step([]int32{4, 4}) {
	}
	client, err := Connect(testContext(t), again.Address, Options{})
	must(t, err)
	t.Cleanup(func() { client.Close() })
	namesake, err := client.CreatePool(testContext(t), "", easy(2, "maze"), PoolOptions{})
	must(t, err)
	if namesake.Name() != name {
		t.Fatal(namesake.Name(), name)
	}
	expectError(t, env.Close(), codes.NotFound)
	_, err = client.GetPool(testContext(t), name, PoolOptions{})
	must(t, err)
}
