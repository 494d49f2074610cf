package procgenclient

import (
	"context"
	"math/rand"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "procgenclient/procgenv1"
)

// VectorEnv is a connection with one pool of one game, in few lines of code. Like bufio.Scanner it
// keeps the first error, which Close returns. It must be used by one goroutine at a time.
type VectorEnv struct {
	// Batch is the result of the last Step; before the first Step, the first observations. nil after
	// an error.
	Batch *Batch

	ctx    context.Context
	client *Client
	pool   *Pool
	err    error
}

// NewVectorEnv connects to a server and creates a pool of envCount environments of a game. The pool
// is deleted by Close.
func NewVectorEnv(ctx context.Context, address, game string, envCount int) *VectorEnv {
	e := &VectorEnv{ctx: ctx}
	if e.client, e.err = Connect(ctx, address, Options{}); e.err != nil {
		return e
	}
	spec := &pb.PoolSpec{Games: []string{game}, EnvCount: int32(envCount)}
	if e.pool, e.err = e.client.CreatePool(ctx, "", spec, PoolOptions{}); e.err == nil {
		e.Batch, e.err = e.pool.Observe(ctx, Slice{})
	}
	return e
}

// Step steps all environments. It returns false after an error, of this call or an earlier one.
func (e *VectorEnv) Step(actions []int32) bool {
	if e.err == nil {
		e.Batch, e.err = e.pool.Step(e.ctx, actions, StepOptions{})
	}
	return e.err == nil
}

// SampleActions returns a random action for each environment; nil without a pool.
func (e *VectorEnv) SampleActions() []int32 {
	if e.pool == nil {
		return nil
	}
	actions := make([]int32, e.pool.EnvCount())
	for i := range actions {
		actions[i] = rand.Int31n(actionMax + 1)
	}
	return actions
}

// Close deletes the pool, closes the connection, and returns the first error.
func (e *VectorEnv) Close() error {
	switch code := status.Code(e.err); {
	case e.pool == nil:
	case code == codes.NotFound || code == codes.Unavailable: // Lost: its name may be another pool's.
		e.pool.Detach(e.ctx)
	default:
		if err := e.pool.Delete(e.ctx); e.err == nil {
			e.err = err
		}
	}
	if e.client != nil {
		e.client.Close()
	}
	return e.err
}
