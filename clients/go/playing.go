package procgenclient

import (
	"context"
	"math/rand"

	pb "procgenclient/procgenv1"
)

// Playing is a connection with one pool of one game, for programs that want no more. As a bufio.Scanner does, it keeps the
// first error, which Close tells. One goroutine at a time.
type Playing struct {
	// How the environments stand after the last Step; before the first, as they were made. nil after an error.
	Batch *Batch

	ctx    context.Context
	client *Client
	pool   *Pool
	err    error
}

// Play connects to a server and makes a pool of a game with so many environments.
func Play(ctx context.Context, address, game string, envCount int) *Playing {
	p := &Playing{ctx: ctx}
	if p.client, p.err = Connect(ctx, address, Options{}); p.err != nil {
		return p
	}
	spec := &pb.PoolSpec{Games: []string{game}, EnvCount: int32(envCount)}
	if p.pool, p.err = p.client.CreatePool(ctx, "", spec, HoldOptions{}); p.err == nil {
		p.Batch, p.err = p.pool.Observe(ctx, Slice{})
	}
	return p
}

// Step steps each environment; false: it went wrong, now or before.
func (p *Playing) Step(actions []int32) bool {
	if p.err == nil {
		p.Batch, p.err = p.pool.Step(p.ctx, actions, StepOptions{})
	}
	return p.err == nil
}

// SampleActions gives an action for each environment, at random.
func (p *Playing) SampleActions() []int32 {
	if p.pool == nil {
		return nil
	}
	actions := make([]int32, p.pool.EnvCount())
	for i := range actions {
		actions[i] = rand.Int31n(actionMax + 1)
	}
	return actions
}

// Close deletes the pool and ends the connection; it gives the first error that there was.
func (p *Playing) Close() error {
	if p.pool != nil {
		if err := p.pool.Delete(p.ctx); p.err == nil {
			p.err = err
		}
	}
	if p.client != nil {
		p.client.Close()
	}
	return p.err
}
