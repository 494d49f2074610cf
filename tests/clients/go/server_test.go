package procgenclient

// A server for all tests, and connections to it.

import (
	"context"
	"fmt"
	"os"
	"strings"
	"testing"
	"time"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "procgenclient/procgenv1"
)

var server *ServerProcess

func TestMain(m *testing.M) {
	var err error
	// A request limit that not all snapshots fit into.
	if server, err = StartServer("", "--workers=2", "--request_bytes_max=65536"); err != nil {
		fmt.Fprintln(os.Stderr, err)
		os.Exit(1)
	}
	result := m.Run()
	if err := server.Stop(); err != nil {
		fmt.Fprintln(os.Stderr, "the server ended by", err)
		result = 1
	}
	os.Exit(result)
}

// Longer than any wait of a test.
func testContext(t *testing.T) context.Context {
	ctx, cancel := context.WithTimeout(context.Background(), 2*time.Minute)
	t.Cleanup(cancel)
	return ctx
}

func connected(t *testing.T, options Options) *Client {
	t.Helper()
	client, err := Connect(testContext(t), server.Address, options)
	must(t, err)
	t.Cleanup(func() { client.Close() })
	return client
}

// Fixed levels.
func easy(count int32, games ...string) *pb.PoolSpec {
	seed := int64(5)
	return &pb.PoolSpec{
		Games:    games,
		EnvCount: count,
		Options: &pb.EnvironmentOptions{
			DistributionMode: pb.DistributionMode_DISTRIBUTION_MODE_EASY, RandSeed: &seed,
		},
	}
}

// Creates a pool and deletes it after the test.
func madePool(t *testing.T, client *Client, spec *pb.PoolSpec, options PoolOptions) *Pool {
	t.Helper()
	pool, err := client.CreatePool(testContext(t), "", spec, options)
	must(t, err)
	t.Cleanup(func() { _ = pool.Delete(context.Background()) })
	return pool
}

// Actions that differ by step and environment.
func actionsOf(step, count int) []int32 {
	actions := make([]int32, count)
	for i := range actions {
		actions[i] = int32((step*31+i*17)%16 - 1)
	}
	return actions
}

func must(t *testing.T, err error) {
	t.Helper()
	if err != nil {
		t.Fatal(err)
	}
}

func stepped(t *testing.T, pool *Pool, actions []int32, options StepOptions) *Batch {
	t.Helper()
	batch, err := pool.Step(testContext(t), actions, options)
	must(t, err)
	return batch
}

func expectError(t *testing.T, err error, code codes.Code, words ...string) {
	t.Helper()
	if status.Code(err) != code {
		t.Fatalf("%v, where %v was expected", err, code)
	}
	for _, word := range words {
		if !strings.Contains(err.Error(), word) {
			t.Errorf("%q does not contain %q", err, word)
		}
	}
}
