package procgenclient

import (
	"context"
	"math/rand"

	pb "procgenclient/procgenv1"
)

// VectorEnv is a connection with one pool of one game, for programs that want no more. As a bufio.Scanner does, it keeps the
// first error, which Close tells. One goroutine at a time.
type VectorEnv struct {
	// How the environments stand after the last Step; before the first, as they were made. nil after an error.
	Batch *Batch

	ctx    context.Context
	client *Client
	pool   *Pool
	err    error
}

// NewVectorEnv connects to a server and makes a pool of a game with so many environments.
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

// Step steps each environment; false: it went wrong, now or before.
func (e *VectorEnv) Step(actions []int32) bool {
	if e.err == nil {
		e.Batch, e.err = e.pool.Step(e.ctx, actions, StepOptions{})
	}
	return e.err == nil
}

// SampleActions gives an action for each environment, at random.
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

// Close deletes the pool and ends the connection; it gives the first error that there was.
func (e *VectorEnv) Close() error {
	if e.pool != nil {
		if err := e.pool.Delete(e.ctx); e.err == nil {
			e.err = err
		}
	}
	if e.client != nil {
		e.client.Close()
	}
	return e.err
}
