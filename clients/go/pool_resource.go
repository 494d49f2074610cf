package procgenclient

import (
	"context"
	"time"

	"google.golang.org/protobuf/proto"
	"google.golang.org/protobuf/types/known/durationpb"

	pb "procgenclient/procgenv1"
)

// A pool's calls beside the stream. The server executes each between two requests of the pool's
// stream. Those that save, restore or clone states return FAILED_PRECONDITION while requests of
// this Pool are unanswered.

// Upper bound of a state's overhead in a request, in bytes: a tag and a length.
const stateOverheadBytes = 8

// SaveStates returns snapshots of environments (none given: all), in this order. A snapshot can be
// restored in any environment of the same game on any server, which then continues identically, bit
// for bit.
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

// RestoreStates restores snapshots in the environments State.Environment. All or nothing if they
// fit in one request (Limits.request_bytes_max). Otherwise several requests are sent, and those
// before an error stay restored.
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

// CloneSource is the source of CloneStates. The zero value is the same pool.
type CloneSource struct {
	// Pool is the name of the source pool. Empty: the same pool (with Server: the pool of the same
	// name there).
	Pool string
	// Server is the address of its server, as this pool's server reaches it. Empty: the same server.
	Server string
}

// CloneStates copies states to environments of this pool. All or nothing; all sources are read
// before any target is written.
func (p *Pool) CloneStates(ctx context.Context, source CloneSource, pairs ...*pb.ClonePair) error {
	if err := p.requireNothingInFlight(); err != nil {
		return err
	}
	_, err := p.client.states.CloneStates(p.client.with(ctx), &pb.CloneStatesRequest{
		Pool: p.Name(), SourcePool: source.Pool, SourceServer: source.Server, Pairs: pairs,
	})
	return fromRPC(ctx, err)
}

// GetEpisode returns an episode of an environment: the last that ended (EPISODE_SELECTOR_LAST) or
// the current one (EPISODE_SELECTOR_CURRENT). Episode in proto/procgen/v1/states.proto documents
// how to replay it. FAILED_PRECONDITION: no episode has ended yet, or the next has not started.
func (p *Pool) GetEpisode(ctx context.Context, environment int32, selector pb.EpisodeSelector) (*pb.Episode, error) {
	return p.episode(ctx, &pb.GetEpisodeRequest{Environment: environment, Selector: selector})
}

// FindEpisode returns an episode of an environment that ended, by its fingerprint
// (Batch.Fingerprints), which is not 0. NOT_FOUND: the server has not this episode, or not any more:
// it has those of a pool's last 1,000, or fewer if they are long.
func (p *Pool) FindEpisode(ctx context.Context, environment int32, fingerprint uint64) (*pb.Episode, error) {
	return p.episode(ctx, &pb.GetEpisodeRequest{Environment: environment, Fingerprint: int64(fingerprint)})
}

func (p *Pool) episode(ctx context.Context, request *pb.GetEpisodeRequest) (*pb.Episode, error) {
	request.Pool = p.Name()
	episode, err := p.client.states.GetEpisode(p.client.with(ctx), request)
	if err == nil && episode.Environment != request.Environment {
		return nil, wrong("an episode of environment %d, expected: %d", episode.Environment, request.Environment)
	}
	return episode, fromRPC(ctx, err)
}

// KeepLease leaves the duration of a pool's lease as it is.
const KeepLease time.Duration = -1

// Renew restarts the pool's lease. lease is its new duration: KeepLease, or 0 for no lease; then the
// pool lives until it is deleted.
func (p *Pool) Renew(ctx context.Context, lease time.Duration) error {
	request := &pb.RenewPoolRequest{Name: p.Name()}
	if lease != KeepLease {
		request.LeaseDuration = durationpb.New(lease)
	}
	_, err := p.client.pools.RenewPool(p.client.with(ctx), request)
	return fromRPC(ctx, err)
}
