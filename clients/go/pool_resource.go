package procgenclient

import (
	"context"
	"time"

	"google.golang.org/protobuf/proto"
	"google.golang.org/protobuf/types/known/durationpb"

	pb "procgenclient/procgenv1"
)

// What can be asked of a pool from beside its stream. These calls happen between two requests of whoever steps it. Those that
// save, restore or clone states are FAILED_PRECONDITION while requests of its own are unanswered.

// What a state has in a request besides its own bytes, at most: a tag and a length.
const stateOverheadBytes = 8

// SaveStates takes snapshots of environments (all, unless told which), in the order asked for. An environment that is put
// into one goes on as this one does, bit for bit, in any pool of the same game on any server.
func (p *Pool) SaveStates(ctx context.Context, environments ...int32) ([]*pb.State, error) {
	if err := p.requireNothingInFlight(); err != nil {
		return nil, err
	}
	var states []*pb.State
	request := &pb.SaveStatesRequest{Pool: p.Name(), Environments: environments}
	if len(environments) == 0 {
		environments = firstEnvs(p.EnvCount())
	}
	for {
		page, err := p.client.states.SaveStates(p.client.with(ctx), request)
		if err != nil {
			return nil, fromRPC(ctx, err)
		}
		if err := checkStates(page, environments, len(states)); err != nil {
			return nil, err
		}
		states = append(states, page.States...)
		if request.PageToken = page.NextPageToken; request.PageToken == "" {
			return states, nil
		}
	}
}

// RestoreStates puts environments (State.Environment) into saved states. All or nothing, as long as they fit one request of
// the server; more are sent in several, and those before one that is refused are restored.
func (p *Pool) RestoreStates(ctx context.Context, states []*pb.State) error {
	if err := p.requireNothingInFlight(); err != nil {
		return err
	}
	bytesMax := int(p.client.catalog.Limits.RequestBytesMax)
	for len(states) > 0 {
		request := &pb.RestoreStatesRequest{Pool: p.Name()}
		bytes := proto.Size(request)
		for _, state := range states {
			bytes += proto.Size(state) + stateOverheadBytes
			if len(request.States) > 0 && bytes > bytesMax {
				break
			}
			request.States = append(request.States, state)
		}
		if _, err := p.client.states.RestoreStates(p.client.with(ctx), request); err != nil {
			return fromRPC(ctx, err)
		}
		states = states[len(request.States):]
	}
	return nil
}

// CloneSource is where states are cloned from; the zero value is the same pool.
type CloneSource struct {
	// Name of the pool that is read. Empty: the same (on another server: the one of the same name).
	Pool string
	// Address of its server, as this pool's server can reach it. Empty: the same.
	Server string
}

// CloneStates puts environments of this pool into the states of others. All or nothing; all are read before any is written.
func (p *Pool) CloneStates(ctx context.Context, source CloneSource, pairs ...*pb.ClonePair) error {
	if err := p.requireNothingInFlight(); err != nil {
		return err
	}
	_, err := p.client.states.CloneStates(p.client.with(ctx), &pb.CloneStatesRequest{
		Pool: p.Name(), SourcePool: source.Pool, SourceServer: source.Server, Pairs: pairs,
	})
	return fromRPC(ctx, err)
}

// GetEpisode tells what happened in an episode of an environment, the last that ended (EPISODE_SELECTOR_LAST) or the one under
// way (EPISODE_SELECTOR_CURRENT), so that it can be played again: the comments of Episode (proto/procgen/v1/states.proto) say
// how. FAILED_PRECONDITION: none has ended yet, or the next has not begun.
func (p *Pool) GetEpisode(ctx context.Context, environment int32, selector pb.EpisodeSelector) (*pb.Episode, error) {
	episode, err := p.client.states.GetEpisode(p.client.with(ctx),
		&pb.GetEpisodeRequest{Pool: p.Name(), Environment: environment, Selector: selector})
	if err == nil && episode.Environment != environment {
		return nil, wrong("an episode of environment %d, expected: %d", episode.Environment, environment)
	}
	return episode, fromRPC(ctx, err)
}

// Renew begins the pool's lease anew: its time to live while nobody steps it. lease: its length from now on; 0: as it is.
func (p *Pool) Renew(ctx context.Context, lease time.Duration) error {
	request := &pb.RenewPoolRequest{Name: p.Name()}
	if lease != 0 {
		request.LeaseDuration = durationpb.New(lease)
	}
	_, err := p.client.pools.RenewPool(p.client.with(ctx), request)
	return fromRPC(ctx, err)
}
