package procgenclient

import (
	"context"

	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

// Actions are in [actionMin, actionMax]; actionMin does nothing and ends the episode.
const actionMin = -1
const actionMax = 14

// Default of the server's largest response, in bytes.
const responseBytesDefault = 4 << 20

// Upper bound of a response for one environment without its observations, in bytes.
const rowOverheadBytes = 1024

// Bounds of the default chunk count: smaller chunks, in bytes of observations, cost more than they
// save; more chunks save nothing.
const chunkBytesMin = 2 << 20
const defaultChunkCountMax = 4

// PoolOptions configures the stream of a pool. The zero value selects the defaults.
type PoolOptions struct {
	// RequestsInFlightMax is the maximum number of unanswered requests. 0: 2.
	RequestsInFlightMax int32
	// ChunkCount is the number of responses to a step of the whole pool (Step.chunk_count), 1 to 64.
	// 0: one for each 2 MiB of observations, 1 to 4.
	ChunkCount int32
	// HeldBatchesMax is, with shared memory, the maximum number of unreleased batches, in addition to
	// those of unanswered requests. 0: 2.
	HeldBatchesMax int32
}

// AttachOptions configures Attach. The zero value selects the defaults.
type AttachOptions struct {
	// TakeOver ends another client's stream, if one is attached. Otherwise that is
	// FAILED_PRECONDITION.
	TakeOver bool
	// ResponseBytesMax is the largest response, in bytes. 0: 4 MiB, or more if one environment needs
	// it.
	ResponseBytesMax int64
}

// StepOptions configures a step. The zero value selects the defaults.
type StepOptions struct {
	// FirstEnv is the index of the first environment of the slice.
	FirstEnv int
	// EnvCount is the number of environments of the slice. 0: all from FirstEnv to the end of the
	// pool.
	EnvCount int
	// Blind: observations are not rendered or sent, which is many times faster.
	Blind bool
	// RepeatCount is the number of times that the action is taken, in [1, 1000]. An environment stops
	// early when it completes its level or its episode ends. 0: 1.
	RepeatCount int32
	// FinalObservations: also return the last observation of each episode that ends. Useful with
	// AUTORESET_MODE_SAME_STEP only.
	FinalObservations bool
	// NextLevels contains the seed of the next level by environment.
	NextLevels map[int32]int32
	// Resets are environments that start a new episode in place of being stepped.
	Resets []*pb.Reset
}

// Slice is a range of a pool's environments. The zero value is the whole pool.
type Slice struct {
	// FirstEnv is the index of the first environment.
	FirstEnv int
	// EnvCount is the number of environments. 0: all from FirstEnv to the end of the pool.
	EnvCount int
	// Blind: without observations.
	Blind bool
}

// Pool is a set of environments that are stepped as one batch.
//
// Step sends a request and waits for its answer. To keep both sides busy, send ahead: SendStep and
// Receive are the two halves of Step. Up to RequestsInFlightMax requests may be unanswered, and
// answers arrive in order.
//
// The first request attaches to the pool: no other client can step it until Detach. After a broken
// connection the pool attaches again and resends unanswered requests. An error of the server ends
// the stream, and outstanding answers are lost. The environments are then in the state before the
// failed request, and the next request attaches again. If a context ends during Receive, the stream
// ends, but requests that were sent are executed. The next request takes the pool over.
//
// A Pool must be used by one goroutine at a time, except for Watch.
type Pool struct {
	client     *Client
	message    *pb.Pool
	inFlight   int32 // Maximum number of unanswered requests.
	chunkCount int32
	heldMax    int32
	stream     *stream
	memory     *sharedMemory // nil without shared memory.
	// The last stream was cancelled, which the server may not have detected yet.
	abandoned bool
}

func newPool(client *Client, message *pb.Pool, options PoolOptions) (*Pool, error) {
	pool := &Pool{client: client, message: message, inFlight: options.RequestsInFlightMax, chunkCount: options.ChunkCount,
		heldMax: options.HeldBatchesMax}
	if pool.inFlight == 0 {
		pool.inFlight = 2
	}
	if pool.chunkCount == 0 {
		pool.chunkCount = int32(clamp(pool.EnvCount()*int(message.ObservationBytes)/chunkBytesMin, 1, defaultChunkCountMax))
	}
	if pool.chunkCount < 1 || pool.chunkCount > 64 {
		return nil, invalid("ChunkCount is %d, allowed: 0 to 64", pool.chunkCount)
	}
	return pool, nil
}

// Name returns the pool's resource name, e.g. "pools/7".
func (p *Pool) Name() string { return p.message.Name }

// Spec returns the spec of the pool, every default filled in, including a rand_seed that the server
// drew.
func (p *Pool) Spec() *pb.PoolSpec { return p.message.Spec }

// EnvCount returns the number of environments, N.
func (p *Pool) EnvCount() int { return int(p.message.Spec.EnvCount) }

// ObservationShape returns the shape of one environment's observation, [64, 64, 3] by default.
func (p *Pool) ObservationShape() []int32 { return p.message.ObservationShape }

// RequestsInFlightMax returns the maximum number of unanswered requests.
func (p *Pool) RequestsInFlightMax() int { return int(p.inFlight) }

// InFlight returns the number of unanswered requests.
func (p *Pool) InFlight() int {
	if p.stream == nil {
		return 0
	}
	return len(p.stream.unanswered)
}

// Step steps a slice and waits for the answer. Actions are in [-1, 15), one for each environment of
// the slice; -1 does nothing and ends the episode.
func (p *Pool) Step(ctx context.Context, actions []int32, options StepOptions) (*Batch, error) {
	if err := p.requireNothingInFlight(); err != nil {
		return nil, err
	}
	if err := p.SendStep(ctx, actions, options); err != nil {
		return nil, err
	}
	return p.Receive(ctx)
}

// Observe returns the current values of a slice, e.g. the first observations, and changes nothing.
// Rewards and episode ends repeat those of the last step: do not sum them.
func (p *Pool) Observe(ctx context.Context, slice Slice) (*Batch, error) {
	if err := p.requireNothingInFlight(); err != nil {
		return nil, err
	}
	if err := p.SendObserve(ctx, slice); err != nil {
		return nil, err
	}
	return p.Receive(ctx)
}

// Reset starts new episodes in some environments of a slice (nil: all), and returns the slice.
func (p *Pool) Reset(ctx context.Context, resets []*pb.Reset, slice Slice) (*Batch, error) {
	if err := p.requireNothingInFlight(); err != nil {
		return nil, err
	}
	of, err := p.slice(slice)
	if err != nil {
		return nil, err
	}
	if resets == nil {
		for i := int32(0); i < of.EnvCount; i++ {
			resets = append(resets, &pb.Reset{Environment: of.FirstEnv + i})
		}
	}
	reset := &pb.ResetSlice{Slice: of, Resets: resets, Observation: observation(slice.Blind)}
	if err := p.send(ctx, &pb.StepPoolRequest{Request: &pb.StepPoolRequest_Reset_{Reset_: reset}}); err != nil {
		return nil, err
	}
	return p.Receive(ctx)
}

// SetLevelSampler replaces the pool's level sampler, from each environment's next choice of a
// level.
func (p *Pool) SetLevelSampler(ctx context.Context, sampler *pb.LevelSampler) error {
	if err := p.requireNothingInFlight(); err != nil {
		return err
	}
	request := &pb.StepPoolRequest{Request: &pb.StepPoolRequest_LevelSampler{LevelSampler: sampler}}
	if err := p.send(ctx, request); err != nil {
		return err
	}
	_, err := p.receiveParts(ctx)
	return err
}

// SendStep sends the request of Step; Receive returns the answer. FAILED_PRECONDITION:
// RequestsInFlightMax requests are unanswered; nothing was sent.
func (p *Pool) SendStep(ctx context.Context, actions []int32, options StepOptions) error {
	slice, err := p.slice(Slice{FirstEnv: options.FirstEnv, EnvCount: options.EnvCount})
	if err != nil {
		return err
	}
	if len(actions) != int(slice.EnvCount) {
		return invalid("actions has %d entries; %s has %d environments from %d on (FirstEnv and EnvCount choose a slice)",
			len(actions), p.Name(), slice.EnvCount, slice.FirstEnv)
	}
	for i, action := range actions {
		if action < actionMin || action > actionMax {
			return invalid("actions[%d] is %d, allowed: %d to %d", i, action, actionMin, actionMax)
		}
	}
	if options.RepeatCount < 0 || options.RepeatCount > 1000 {
		return invalid("RepeatCount is %d, allowed: 0 to 1000", options.RepeatCount)
	}
	step := &pb.Step{
		Slice:                 slice,
		Actions:               append([]int32(nil), actions...), // A copy, because it may be resent.
		RepeatCount:           options.RepeatCount,
		Observation:           observation(options.Blind),
		WithFinalObservations: options.FinalObservations,
		Resets:                options.Resets,
	}
	if !options.Blind && len(actions) == p.EnvCount() {
		step.ChunkCount = p.chunkCount
	}
	for environment, seed := range options.NextLevels {
		step.NextLevels = append(step.NextLevels, &pb.NextLevel{Environment: environment, LevelSeed: seed})
	}
	return p.send(ctx, &pb.StepPoolRequest{Request: &pb.StepPoolRequest_Step{Step: step}})
}

// SendObserve sends the request of Observe; Receive returns the answer.
func (p *Pool) SendObserve(ctx context.Context, slice Slice) error {
	of, err := p.slice(slice)
	if err != nil {
		return err
	}
	observe := &pb.Observe{Slice: of, Observation: observation(slice.Blind)}
	return p.send(ctx, &pb.StepPoolRequest{Request: &pb.StepPoolRequest_Observe{Observe: observe}})
}

// Receive waits for the answer to the oldest unanswered request.
func (p *Pool) Receive(ctx context.Context) (*Batch, error) {
	parts, err := p.receiveParts(ctx)
	if err != nil {
		return nil, err
	}
	return assemble(parts, p.ObservationShape()), nil
}

// Attach attaches to the pool. Optional: the first request does it.
func (p *Pool) Attach(ctx context.Context, options AttachOptions) error {
	if p.stream != nil {
		return nil
	}
	if options.ResponseBytesMax == 0 {
		options.ResponseBytesMax = p.responseBytesMax()
	}
	opened, err := openStream(ctx, p.client, &pb.Attach{
		Pool:                p.Name(),
		RequestsInFlightMax: p.inFlight,
		TakeOver:            options.TakeOver || p.abandoned,
		ResponseBytesMax:    options.ResponseBytesMax,
		HeldBatchesMax:      p.heldMax,
	}, p.message, p.memory)
	if err != nil {
		return err
	}
	p.stream, p.memory = opened, opened.memory
	p.abandoned = false
	p.inFlight = opened.attached.RequestsInFlightMax
	return nil
}

// Detach ends the stream, so that another client can attach. Unanswered requests are executed;
// their answers are lost.
func (p *Pool) Detach(ctx context.Context) {
	if p.stream != nil {
		p.stream.close(ctx)
		p.stream = nil
	}
	if p.memory != nil && p.memory.heldCount() == 0 {
		p.memory.leave()
		p.memory = nil
	}
}

// Delete detaches and deletes the pool. Batches of shared memory stay valid until they are
// released.
func (p *Pool) Delete(ctx context.Context) error {
	p.Detach(ctx)
	if p.memory != nil {
		p.memory.leave()
		p.memory = nil
	}
	return p.client.DeletePool(ctx, p.Name())
}

func (p *Pool) send(ctx context.Context, request *pb.StepPoolRequest) error {
	if p.InFlight() >= int(p.inFlight) {
		return newError(codes.FailedPrecondition, "%d requests to %s are unanswered, of at most %d: receive first",
			p.InFlight(), p.Name(), p.inFlight)
	}
	if err := p.Attach(ctx, AttachOptions{}); err != nil {
		return err
	}
	if p.memory != nil && p.memory.heldCount()+p.InFlight() >= int(p.memory.message.BatchCount) {
		return newError(codes.FailedPrecondition, "%d batches of %s are unreleased and %d requests unanswered, of %d batches: "+
			"release some, or use a larger HeldBatchesMax", p.memory.heldCount(), p.Name(), p.InFlight(),
			p.memory.message.BatchCount)
	}
	p.stream.send(request)
	return nil
}

func (p *Pool) receiveParts(ctx context.Context) ([]*part, error) {
	if p.InFlight() == 0 {
		return nil, newError(codes.FailedPrecondition, "no request to %s is unanswered: send first", p.Name())
	}
	parts, err := p.stream.receive(ctx)
	if err != nil {
		p.stream = nil
		p.abandoned = ctx.Err() != nil
	}
	return parts, err
}

func (p *Pool) requireNothingInFlight() error {
	if p.InFlight() > 0 {
		return newError(codes.FailedPrecondition, "%d requests to %s are unanswered: receive them first", p.InFlight(), p.Name())
	}
	return nil
}

// Returns 0, the server's default, or more if one environment needs it.
func (p *Pool) responseBytesMax() int64 {
	observationBytes := int64(p.message.ObservationBytes)
	sent := observationBytes
	if p.Spec().Encoding != pb.Encoding_ENCODING_RAW {
		sent = sent * 3 / 2 // Upper bound of an encoded one; a final one is never encoded.
	}
	row := sent + observationBytes + rowOverheadBytes
	if row <= responseBytesDefault {
		return 0
	}
	return row
}

func (p *Pool) slice(of Slice) (*pb.Slice, error) {
	if of.EnvCount == 0 {
		of.EnvCount = p.EnvCount() - of.FirstEnv
	}
	if of.FirstEnv < 0 || of.FirstEnv >= p.EnvCount() {
		return nil, invalid("FirstEnv is %d; %s has environments 0 to %d", of.FirstEnv, p.Name(), p.EnvCount()-1)
	}
	if of.EnvCount < 1 || of.FirstEnv+of.EnvCount > p.EnvCount() {
		return nil, invalid("EnvCount is %d from environment %d; %s has %d environments", of.EnvCount, of.FirstEnv,
			p.Name(), p.EnvCount())
	}
	return &pb.Slice{FirstEnv: int32(of.FirstEnv), EnvCount: int32(of.EnvCount)}, nil
}

func observation(blind bool) pb.Observation {
	if blind {
		return pb.Observation_OBSERVATION_NONE
	}
	return pb.Observation_OBSERVATION_FRAME
}

func clamp(value, least, most int) int {
	if value < least {
		return least
	}
	if value > most {
		return most
	}
	return value
}
