package procgenclient

import (
	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

// Validation of responses before they are used, because a server may be faulty, malicious or of
// another version. All errors are INTERNAL; the message contains the value given and the value
// expected.

// Bounds of the API: PoolSpec.total_env_count, the largest observation that ObservationFormat
// allows, and State.snapshot.
const envCountMax = 16777216
const observationBytesMax = 16 * 512 * 512 * 3
const snapshotBytesMax = 1 << 20

// A page has 1000 pools; a list with more pages is treated as endless.
const poolPagesMax = 1000

func wrong(format string, arguments ...interface{}) error {
	return newError(codes.Internal, "the server's answer: "+format, arguments...)
}

// A consistent pool of this name (empty: any) with envCount environments (0: any).
func checkPool(pool *pb.Pool, name string, envCount int32) error {
	count := pool.GetSpec().GetEnvCount()
	if pool.GetName() == "" || name != "" && pool.Name != name {
		return wrong("pool %q, expected: %q", pool.GetName(), name)
	}
	if count < 1 || count > envCountMax || envCount != 0 && count != envCount {
		return wrong("a pool of %d environments, expected: %d, or 1 to %d", count, envCount, envCountMax)
	}
	bytes := int64(1)
	for _, side := range pool.ObservationShape {
		if side < 1 || int64(side) > observationBytesMax/bytes {
			return wrong("observations of shape %v, expected: positive sizes, of at most %d bytes", pool.ObservationShape,
				observationBytesMax)
		}
		bytes *= int64(side)
	}
	if len(pool.ObservationShape) == 0 || bytes != int64(pool.ObservationBytes) {
		return wrong("observations of %d bytes, expected: the product of %v", pool.ObservationBytes, pool.ObservationShape)
	}
	return nil
}

// A response to attach, for the pool `known`.
func checkAttached(attached *pb.Attached, attach *pb.Attach, known *pb.Pool) error {
	if err := checkPool(attached.GetPool(), known.Name, known.Spec.EnvCount); err != nil {
		return err
	}
	spec := attached.Pool.Spec
	same := len(attached.Pool.ObservationShape) == len(known.ObservationShape) &&
		spec.Encoding == known.Spec.Encoding && spec.Transport == known.Spec.Transport
	for i := 0; same && i < len(known.ObservationShape); i++ {
		same = attached.Pool.ObservationShape[i] == known.ObservationShape[i]
	}
	if !same {
		return wrong("%s has another shape, encoding or transport than before", known.Name)
	}
	bytesMax := attach.ResponseBytesMax
	if bytesMax == 0 {
		bytesMax = responseBytesDefault
	}
	if attached.RequestsInFlightMax < 1 || attached.ResponseBytesMax < 1 || attached.ResponseBytesMax > bytesMax {
		return wrong("%d requests in flight and responses of %d bytes, expected: at least 1, and 1 to %d",
			attached.RequestsInFlightMax, attached.ResponseBytesMax, bytesMax)
	}
	shares := spec.Transport == pb.Transport_TRANSPORT_SHARED_MEMORY
	if attached.NextSequenceNumber < 1 || shares != (attached.SharedMemory != nil) {
		return wrong("next request %d, shared memory: %v, expected: 1 or more, and %v", attached.NextSequenceNumber,
			attached.SharedMemory != nil, shares)
	}
	return nil
}

// The answer that a request must get.
type expected struct {
	first, count         int
	observations, finals bool // Whether they were requested.
	ack                  bool // An ack in place of values.
	observationBytes     int
	isEncoded, shares    bool
	responseBytesMax     int64
}

func (s *stream) expected(request *pb.StepPoolRequest) expected {
	known := s.known
	of := expected{
		count:            int(known.Spec.EnvCount),
		observationBytes: int(known.ObservationBytes),
		isEncoded:        s.decoder != nil,
		shares:           s.memory != nil,
		responseBytesMax: s.attached.ResponseBytesMax,
	}
	slice, wanted := request.GetObserve().GetSlice(), request.GetObserve().GetObservation()
	if step := request.GetStep(); step != nil {
		slice, wanted, of.finals = step.Slice, step.Observation, step.WithFinalObservations
	} else if reset := request.GetReset_(); reset != nil {
		slice, wanted = reset.Slice, reset.Observation
	}
	of.ack = request.GetLevelSampler() != nil
	of.observations = wanted != pb.Observation_OBSERVATION_NONE
	if slice != nil {
		of.first, of.count = int(slice.FirstEnv), int(slice.EnvCount)
	}
	return of
}

// Checks the next response to a request, after the parts `before`.
func (of expected) check(got *part, before []*part) error {
	next := of.first
	for _, part := range before {
		next += part.count
	}
	number, left := got.SequenceNumber, of.first+of.count-next
	if of.ack {
		return wrong("request %d with values, expected: an ack", number)
	}
	if got.FirstEnv != next || got.count < 1 || got.count > left {
		return wrong("request %d: %d environments from %d, expected: 1 to %d from %d", number, got.count, got.FirstEnv,
			left, next)
	}
	if got.last != (got.count == left) {
		return wrong("request %d: environment %d is the last: %v, expected: %d", number, next+got.count-1, got.last,
			next+left-1)
	}
	if of.shares != (got.shared != nil) {
		return wrong("request %d: values in shared memory: %v, expected: %v", number, got.shared != nil, of.shares)
	}
	if of.shares {
		if !got.last || got.shared.observations != of.observations || got.shared.finals != of.finals {
			return wrong("request %d: several responses, or other observations than requested", number)
		}
		return nil
	}
	return of.checkArrays(got)
}

func (of expected) checkArrays(got *part) error {
	number := got.SequenceNumber
	for _, length := range []int{len(got.Rewards), len(got.First), len(got.Terminated), len(got.Truncated),
		len(got.LevelSeeds), len(got.PrevLevelSeeds), len(got.PrevLevelComplete), len(got.EpisodeReturns),
		len(got.EpisodeLengths)} {
		if length != got.count {
			return wrong("request %d: an array of %d values, expected: %d", number, length, got.count)
		}
	}
	ended := 0
	for i := range got.Terminated {
		if got.Terminated[i] || got.Truncated[i] {
			ended++
		}
	}
	if size := len(got.Fingerprints); size != 0 && size != ended { // 0: a server without fingerprints.
		return wrong("request %d: %d fingerprints, expected: %d", number, size, ended)
	}
	if size := len(got.FinalObservations); size != 0 && (!of.finals || size != ended*of.observationBytes) {
		return wrong("request %d: %d bytes of final observations, expected: those requested, of %d episodes", number, size,
			ended)
	}
	size, decoded := len(got.Observations), got.count*of.observationBytes
	if of.isEncoded && of.observations {
		// The server sizes responses by raw observations, so the decoded size is bounded.
		if size == 0 || int64(decoded) > of.responseBytesMax {
			return wrong("request %d: %d bytes of %d encoded observations, expected: some, of up to %d bytes when decoded",
				number, size, got.count, of.responseBytesMax)
		}
		return nil
	}
	if !of.observations {
		decoded = 0
	}
	if size != decoded {
		return wrong("request %d: %d bytes of observations, expected: %d", number, size, decoded)
	}
	return nil
}

// A page of snapshots of `environments`, after `before` snapshots on earlier pages.
func checkStates(page *pb.SaveStatesResponse, environments []int32, before int) error {
	count := before + len(page.States)
	isLast := page.NextPageToken == ""
	if len(page.States) == 0 || count > len(environments) || isLast != (count == len(environments)) {
		return wrong("%d states after %d, the last: %v, expected: %d in all", len(page.States), before, isLast,
			len(environments))
	}
	for i, state := range page.States {
		if size := len(state.Snapshot); state.Environment != environments[before+i] || size < 1 || size > snapshotBytesMax {
			return wrong("a snapshot of %d bytes of environment %d, expected: 1 to %d of %d", size, state.Environment,
				snapshotBytesMax, environments[before+i])
		}
	}
	return nil
}

// Frames of `environments` in this order, raw RGB.
func checkFrames(frames []*pb.Frame, environments []int32, sizePx int32) error {
	if len(frames) != len(environments) {
		return wrong("%d frames, expected: %d", len(frames), len(environments))
	}
	for i, frame := range frames {
		if frame.Environment != environments[i] || frame.SizePx != sizePx ||
			len(frame.Image) != 3*int(sizePx)*int(sizePx) {
			return wrong("a frame of environment %d of %d x %d pixels in %d bytes, expected: %d and a square of %d",
				frame.Environment, frame.SizePx, frame.SizePx, len(frame.Image), environments[i], sizePx)
		}
	}
	return nil
}
