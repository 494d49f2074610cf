package procgenclient

import (
	"context"

	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

// Actions are in [actionMin, actionMax]; actionMin does nothing and ends the episode.
const actionMin = -1
const actionMax = 14

// What a server sends at most in one response unless told otherwise. In bytes.
const responseBytesDefault = 4 << 20

// What a response for one environment has besides an observation and a final one, at most. In bytes.
const rowOverheadBytes = 1024

// Chunks smaller than this, in bytes of observations, cost more than they save; and more of them than this save nothing.
const chunkBytesMin = 2 << 20
const defaultChunkCountMax = 4

// PoolOptions is how a pool is held; the zero value will do.
type PoolOptions struct {
	// How many requests may be unanswered. 0: 2.
	RequestsInFlightMax int32
	// In how many chunks the whole pool is stepped, 1 to 64: while one is on its way, the next is stepped. 0: as many as
	// pay.
	ChunkCount int32
	// Of a pool that shares memory: how many batches may be unreleased, besides those of unanswered requests. 0: 2.
	HeldBatchesMax int32
}

// AttachOptions is how a pool is taken; the zero value will do.
type AttachOptions struct {
	// End another client's stream, if there is one.
	TakeOver bool
	// Largest response that the server may send, in bytes. 0: 4 MiB, or what one environment's answer takes.
	ResponseBytesMax int64
}

// StepOptions is what may be said of a step; the zero value will do.
type StepOptions struct {
	// Index of the slice's first environment; it has as many as there are actions.
	FirstEnv int
	// No pictures are drawn or sent, which is many times faster.
	Blind bool
	// The same action is taken so many times, in [1, 1000]; an environment stops when its episode ends. 0: 1.
	RepeatCount int32
	// Where an episode ends, its last picture is answered, too. Only of use with AUTORESET_MODE_SAME_STEP.
	FinalObservations bool
	// Level seeds by environment, to be played after the present levels.
	NextLevels map[int32]int32
	// Environments that begin a new episode in place of being stepped.
	Resets []*pb.Reset
}

// Slice is a part of a pool; the zero value is all of it.
type Slice struct {
	FirstEnv int
	// 0: all from the first to the pool's last.
	EnvCount int
	// No pictures.
	Blind bool
}

// Pool is a number of environments that are stepped as one batch.
//
// The simple way is Step. To keep both sides busy, send ahead: SendStep and Receive are the two halves of Step, and up to
// RequestsInFlightMax requests may be unanswered; answers come in the order of the requests.
//
// The first request attaches to the pool: no other client can step it until Detach. Where the connection breaks, the pool
// attaches again by itself and sends again what is unanswered: nothing is seen of it but a pause. After an error of the
// server the stream is over, answers that were still owed are lost, and the next request attaches anew; the environments
// stand as they did before the request at fault. A context that ends while an answer is waited for ends the stream, too, but
// what was sent is carried out; the next request takes the pool over from it.
//
// One goroutine at a time; meanwhile others may Watch.
type Pool struct {
	client     *Client
	message    *pb.Pool
	inFlight   int32 // That may be.
	chunkCount int32
	heldMax    int32
	stream     *stream
	memory     *sharedMemory // Of its streams, if it shares any.
	// The last stream was given up, which the server may not have noticed yet.
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
		return nil, invalid("ChunkCount is %d; it is in [1, 64], or 0", pool.chunkCount)
	}
	return pool, nil
}

// Name is the pool's resource name, e.g. "pools/7".
func (p *Pool) Name() string { return p.message.Name }

// Spec is what the pool was made with, every default filled in (also a rand_seed that the server drew).
func (p *Pool) Spec() *pb.PoolSpec { return p.message.Spec }

// EnvCount is the number of environments, N.
func (p *Pool) EnvCount() int { return int(p.message.Spec.EnvCount) }

// ObservationShape is that of one environment's observation, [64, 64, 3] by default.
func (p *Pool) ObservationShape() []int32 { return p.message.ObservationShape }

// RequestsInFlightMax is how many requests may be unanswered.
func (p *Pool) RequestsInFlightMax() int { return int(p.inFlight) }

// InFlight is the number of requests whose answers were not received yet.
func (p *Pool) InFlight() int {
	if p.stream == nil {
		return 0
	}
	return len(p.stream.unanswered)
}

// Step steps each environment of a slice, and waits for the answer. Actions are in [-1, 15); -1 does nothing and ends the
// episode.
func (p *Pool) Step(ctx context.Context, actions []int32, options StepOptions) (*Batch, error) {
	if err := p.requireNothingInFlight(); err != nil {
		return nil, err
	}
	if err := p.SendStep(ctx, actions, options); err != nil {
		return nil, err
	}
	return p.Receive(ctx)
}

// Observe tells how a slice stands and changes nothing: how a learner gets the first observations.
// Rewards and ends are those of the last step again, not to be added up.
func (p *Pool) Observe(ctx context.Context, slice Slice) (*Batch, error) {
	if err := p.requireNothingInFlight(); err != nil {
		return nil, err
	}
	if err := p.SendObserve(ctx, slice); err != nil {
		return nil, err
	}
	return p.Receive(ctx)
}

// Reset begins new episodes in some environments of a slice (nil: all of it), and tells how it stands.
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

// SetLevelSampler replaces what chooses the levels; takes effect at each environment's next episode.
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

// SendStep sends the request of Step; Receive gives the answer. FAILED_PRECONDITION: RequestsInFlightMax requests are
// unanswered; nothing was sent.
func (p *Pool) SendStep(ctx context.Context, actions []int32, options StepOptions) error {
	if err := p.checkSlice(options.FirstEnv, len(actions), "actions"); err != nil {
		return err
	}
	for i, action := range actions {
		if action < actionMin || action > actionMax {
			return invalid("actions[%d] is %d; actions are %d ... %d", i, action, actionMin, actionMax)
		}
	}
	if options.RepeatCount < 0 || options.RepeatCount > 1000 {
		return invalid("RepeatCount is %d; it is in [1, 1000], or 0", options.RepeatCount)
	}
	step := &pb.Step{
		Slice: &pb.Slice{
			FirstEnv: int32(options.FirstEnv),
			EnvCount: int32(len(actions)),
		},
		Actions:               append([]int32(nil), actions...), // It may be sent again.
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

// SendObserve sends the request of Observe.
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

// Attach takes the pool for this object. Never necessary: the first request does so.
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

// Detach lets the pool go, so that another client can attach. Requests in flight are carried out; their answers are lost.
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

// Delete detaches, and ends the pool. Batches of shared memory stay valid until they are released.
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
	if p.memory != nil && p.memory.heldCount()+p.InFlight() >= int(p.memory.told.BatchCount) {
		return newError(codes.FailedPrecondition, "%d batches of %s are unreleased and %d requests unanswered, of %d batches: "+
			"release some, or hold it with a larger HeldBatchesMax", p.memory.heldCount(), p.Name(), p.InFlight(),
			p.memory.told.BatchCount)
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

// 0, for what servers send by default, or more where that has no room for a row.
func (p *Pool) responseBytesMax() int64 {
	observationBytes := int64(p.message.ObservationBytes)
	sent := observationBytes
	if p.Spec().Encoding != pb.Encoding_ENCODING_RAW {
		sent = sent * 3 / 2 // An encoded one may take half as much again; a final one is never encoded.
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
	if err := p.checkSlice(of.FirstEnv, of.EnvCount, "environments"); err != nil {
		return nil, err
	}
	return &pb.Slice{FirstEnv: int32(of.FirstEnv), EnvCount: int32(of.EnvCount)}, nil
}

func (p *Pool) checkSlice(first, count int, what string) error {
	if first < 0 || first >= p.EnvCount() {
		return invalid("FirstEnv is %d; %s has environments 0 ... %d", first, p.Name(), p.EnvCount()-1)
	}
	if count < 1 || first+count > p.EnvCount() {
		return invalid("%d %s from environment %d; %s has %d environments", count, what, first, p.Name(), p.EnvCount())
	}
	return nil
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
