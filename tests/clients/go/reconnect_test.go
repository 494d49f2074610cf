package procgenclient

// Streams that outlive their connections.

import (
	"bufio"
	"context"
	"fmt"
	"os"
	"os/exec"
	"reflect"
	"strings"
	"testing"
	"time"

	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

const half = 6

// Steps the two halves of the pool in turn, with pipelined requests.
func traceOf(t *testing.T, pool *Pool, count int) []*Batch {
	t.Helper()
	ctx := testContext(t)
	// The client does not retry attach.
	for pool.Attach(ctx, AttachOptions{TakeOver: true, ResponseBytesMax: 65536}) != nil {
		must(t, ctx.Err())
	}
	var trace []*Batch
	for sent := 0; len(trace) < count; {
		for ; sent < count && pool.InFlight() < pool.RequestsInFlightMax(); sent++ {
			must(t, pool.SendStep(ctx, actionsOf(sent, half), StepOptions{FirstEnv: sent % 2 * half, EnvCount: half}))
		}
		batch, err := pool.Receive(ctx)
		must(t, err)
		if batch.held != nil {
			batch = owned(batch)
		}
		trace = append(trace, batch)
	}
	return trace
}

func TestFaultyNetworkLosesNothing(t *testing.T) {
	program := os.Getenv("PROCGEN_FAULT_PROXY")
	if program == "" {
		t.Skip("set PROCGEN_FAULT_PROXY")
	}
	client := connected(t, Options{})
	expected := traceOf(t, madePool(t, client, easy(2*half, "maze", "bigfish"), PoolOptions{RequestsInFlightMax: 3}), 150)
	encoded := easy(2*half, "maze", "bigfish")
	encoded.Encoding = pb.Encoding_ENCODING_DELTA_ZSTD
	for name, test := range map[string]struct {
		spec               *pb.PoolSpec
		bytesBetweenFaults string
	}{
		"raw":     {easy(2*half, "maze", "bigfish"), "120000"},
		"encoded": {encoded, "20000"},
		"shared":  {sharing(easy(2*half, "maze", "bigfish")), "1500"},
	} {
		spec, bytesBetweenFaults := test.spec, test.bytesBetweenFaults
		t.Run(name, func(t *testing.T) {
			network := exec.Command(program, server.Address, "11", bytesBetweenFaults)
			input, err := network.StdinPipe()
			must(t, err)
			output, err := network.StdoutPipe()
			must(t, err)
			must(t, network.Start())
			lines := bufio.NewScanner(output)
			lines.Scan()
			address := strings.TrimPrefix(lines.Text(), "listening on ")

			name := madePool(t, client, spec, PoolOptions{}).Name()
			ctx := testContext(t)
			var learner *Client
			for learner, err = Connect(ctx, address, Options{}); err != nil; learner, err = Connect(ctx, address, Options{}) {
				must(t, ctx.Err())
			}
			var pool *Pool
			for pool, err = learner.GetPool(ctx, name, PoolOptions{RequestsInFlightMax: 3}); err != nil; {
				must(t, ctx.Err())
				pool, err = learner.GetPool(ctx, name, PoolOptions{RequestsInFlightMax: 3})
			}
			for step, batch := range traceOf(t, pool, 150) {
				if !reflect.DeepEqual(batch, expected[step]) {
					t.Fatalf("step %d differs", step)
				}
			}
			must(t, learner.Close())
			must(t, input.Close())
			lines.Scan()
			broken := 0
			if _, err := fmt.Sscanf(lines.Text(), "%d broken", &broken); err != nil || broken < 5 {
				t.Error("the network broke", broken, "connections", err)
			}
			must(t, network.Wait())
		})
	}
}

// Starts a server and steps a new pool of two environments on it.
func ownPool(t *testing.T, reconnectTimeout time.Duration, flags ...string) (*ServerProcess, *Pool) {
	t.Helper()
	own, err := StartServer("", append(flags, "--workers=1")...)
	must(t, err)
	t.Cleanup(func() { _ = own.Process.Kill() })
	client, err := Connect(testContext(t), own.Address, Options{ReconnectTimeout: reconnectTimeout})
	must(t, err)
	t.Cleanup(func() { client.Close() })
	pool, err := client.CreatePool(testContext(t), "", easy(2, "maze"), PoolOptions{})
	must(t, err)
	stepped(t, pool, []int32{4, 4}, StepOptions{})
	return own, pool
}

func untilLost(ctx context.Context, pool *Pool) error {
	for {
		if _, err := pool.Step(ctx, []int32{4, 4}, StepOptions{}); err != nil {
			return err
		}
	}
}

func TestReconnectToALostServerTimesOut(t *testing.T) {
	own, pool := ownPool(t, 500*time.Millisecond)
	must(t, own.Process.Kill())
	begin := time.Now()
	expectError(t, untilLost(testContext(t), pool), codes.Unavailable, "made again within 500ms")
	if took := time.Since(begin); took > 10*time.Second {
		t.Error(took)
	}
}

func TestWithoutReconnectTimeoutTheFirstLossIsAnError(t *testing.T) {
	own, pool := ownPool(t, -1)
	must(t, own.Process.Kill())
	err := untilLost(testContext(t), pool)
	expectError(t, err, codes.Unavailable)
	if strings.Contains(err.Error(), "made again") {
		t.Error(err)
	}
}

func TestDrainingServerIsNotContactedAgain(t *testing.T) {
	own, pool := ownPool(t, 10*time.Minute, "--drain_timeout=1s")
	stopped := make(chan error)
	go func() { stopped <- own.Stop() }()
	expectError(t, untilLost(testContext(t), pool), codes.Unavailable, "drains")
	must(t, pool.Delete(testContext(t)))
	must(t, <-stopped)
}

func TestContextEndsTheWaitForALostServer(t *testing.T) {
	own, pool := ownPool(t, 10*time.Minute)
	must(t, own.Process.Kill())
	ctx, cancel := context.WithTimeout(context.Background(), 300*time.Millisecond)
	defer cancel()
	expectError(t, untilLost(ctx, pool), codes.DeadlineExceeded)
}
