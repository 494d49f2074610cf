package procgenclient

import (
	"encoding/binary"
	"errors"
	"math"

	"google.golang.org/protobuf/encoding/protowire"
	"google.golang.org/protobuf/proto"

	pb "procgenclient/procgenv1"
)

// Field numbers of StepPoolResponse and Batch (proto/procgen/v1/step.proto).
const (
	sequenceNumberField = 1
	batchField          = 4

	firstEnvField          = 1
	envCountField          = 2
	lastField              = 3
	sharedBatchField       = 4
	rewardsField           = 5
	firstField             = 6
	terminatedField        = 7
	truncatedField         = 8
	levelSeedsField        = 9
	prevLevelSeedsField    = 10
	prevLevelCompleteField = 11
	episodeReturnsField    = 12
	episodeLengthsField    = 13
	fingerprintsField      = 14
	finalObservationsField = 15
	observationsField      = 16

	sharedObservationsField      = 17
	sharedFinalObservationsField = 18
)

// The gRPC codec of all calls. It is independent of the Protocol Buffers API that the linked gRPC
// uses (Debian's gRPC is older than the generated code).
//
// It parses StepPool responses without copying observations, which Protocol Buffers would do. On
// the wire each array of a batch is the little-endian array (proto/README.md, "On the wire").
// Fields in another valid form (unpacked, or in several pieces) are read through the generated
// message.
type codec struct{}

// Name returns the content subtype.
func (codec) Name() string { return "proto" }

func (codec) Marshal(message interface{}) ([]byte, error) {
	return proto.Marshal(message.(proto.Message))
}

func (codec) Unmarshal(bytes []byte, into interface{}) error {
	if response, is := into.(*response); is {
		return response.read(bytes)
	}
	return proto.Unmarshal(bytes, into.(proto.Message))
}

// A StepPoolResponse: a part if it contains a batch, else the message.
type response struct {
	part    *part
	message *pb.StepPoolResponse
}

var errUnexpectedForm = errors.New("another form than this reader expects")

func (r *response) read(message []byte) error {
	*r = response{}
	if part, err := readBatchResponse(message); err == nil {
		r.part = part
		return nil
	}
	r.message = &pb.StepPoolResponse{}
	if err := proto.Unmarshal(message, r.message); err != nil {
		return err
	}
	if batch := r.message.GetBatch(); batch != nil {
		*r = response{part: partOf(r.message.SequenceNumber, batch)}
	}
	return nil
}

// Converts the generated message.
func partOf(sequenceNumber int64, batch *pb.Batch) *part {
	fingerprints := make([]uint64, len(batch.Fingerprints))
	for i, hash := range batch.Fingerprints {
		fingerprints[i] = uint64(hash)
	}
	var shared *sharedPart
	if batch.SharedBatch != nil {
		shared = &sharedPart{*batch.SharedBatch, batch.SharedObservations, batch.SharedFinalObservations}
	}
	return &part{
		count:  int(batch.EnvCount),
		last:   batch.Last,
		shared: shared,
		Batch: Batch{
			SequenceNumber:    sequenceNumber,
			FirstEnv:          int(batch.FirstEnv),
			Rewards:           batch.Rewards,
			First:             batch.First,
			Terminated:        batch.Terminated,
			Truncated:         batch.Truncated,
			LevelSeeds:        batch.LevelSeeds,
			PrevLevelSeeds:    batch.PrevLevelSeeds,
			PrevLevelComplete: batch.PrevLevelComplete,
			EpisodeReturns:    batch.EpisodeReturns,
			EpisodeLengths:    batch.EpisodeLengths,
			Fingerprints:      fingerprints,
			FinalObservations: batch.FinalObservations,
			Observations:      batch.Observations,
		},
	}
}

// Calls `use` with each field of a message: with its bytes, or with the number of a varint.
func eachField(message []byte, use func(field protowire.Number, bytes []byte, number uint64) error) error {
	seen := map[protowire.Number]bool{}
	for len(message) > 0 {
		field, kind, size := protowire.ConsumeTag(message)
		if size < 0 || seen[field] {
			return errUnexpectedForm
		}
		seen[field] = true
		message = message[size:]
		var bytes []byte
		var number uint64
		switch kind {
		case protowire.VarintType:
			number, size = protowire.ConsumeVarint(message)
		case protowire.BytesType:
			bytes, size = protowire.ConsumeBytes(message)
		default:
			return errUnexpectedForm
		}
		if size < 0 {
			return errUnexpectedForm
		}
		message = message[size:]
		if err := use(field, bytes, number); err != nil {
			return err
		}
	}
	return nil
}

func readBatchResponse(message []byte) (*part, error) {
	read := &part{}
	found := false
	err := eachField(message, func(field protowire.Number, bytes []byte, number uint64) error {
		switch field {
		case sequenceNumberField:
			read.SequenceNumber = int64(number)
			return nil
		case batchField:
			found = true
			return eachField(bytes, read.set)
		}
		return errUnexpectedForm
	})
	if err == nil && !found {
		err = errUnexpectedForm
	}
	return read, err
}

func (p *part) set(field protowire.Number, bytes []byte, number uint64) (err error) {
	switch field {
	case firstEnvField:
		p.FirstEnv = int(number)
	case envCountField:
		p.count = int(number)
	case lastField:
		p.last = number != 0
	case sharedBatchField, sharedObservationsField, sharedFinalObservationsField:
		return errUnexpectedForm // Without observations, the generated message is fast enough.
	case rewardsField:
		p.Rewards, err = floats(bytes)
	case firstField:
		p.First, err = flags(bytes)
	case terminatedField:
		p.Terminated, err = flags(bytes)
	case truncatedField:
		p.Truncated, err = flags(bytes)
	case levelSeedsField:
		p.LevelSeeds, err = integers(bytes)
	case prevLevelSeedsField:
		p.PrevLevelSeeds, err = integers(bytes)
	case prevLevelCompleteField:
		p.PrevLevelComplete, err = flags(bytes)
	case episodeReturnsField:
		p.EpisodeReturns, err = floats(bytes)
	case episodeLengthsField:
		p.EpisodeLengths, err = integers(bytes)
	case fingerprintsField:
		p.Fingerprints, err = hashes(bytes)
	case finalObservationsField:
		p.FinalObservations = bytes
	case observationsField:
		p.Observations = bytes
	}
	return err // Other fields are unknown, and clients ignore them.
}

func floats(bytes []byte) ([]float32, error) {
	if len(bytes)%4 != 0 {
		return nil, errUnexpectedForm
	}
	values := make([]float32, len(bytes)/4)
	for i := range values {
		values[i] = math.Float32frombits(binary.LittleEndian.Uint32(bytes[4*i:]))
	}
	return values, nil
}

func integers(bytes []byte) ([]int32, error) {
	if len(bytes)%4 != 0 {
		return nil, errUnexpectedForm
	}
	values := make([]int32, len(bytes)/4)
	for i := range values {
		values[i] = int32(binary.LittleEndian.Uint32(bytes[4*i:]))
	}
	return values, nil
}

func hashes(bytes []byte) ([]uint64, error) {
	if len(bytes)%8 != 0 {
		return nil, errUnexpectedForm
	}
	values := make([]uint64, len(bytes)/8)
	for i := range values {
		values[i] = binary.LittleEndian.Uint64(bytes[8*i:])
	}
	return values, nil
}

func flags(bytes []byte) ([]bool, error) {
	values := make([]bool, len(bytes))
	for i, flag := range bytes {
		if flag > 1 {
			return nil, errUnexpectedForm // A varint of several bytes.
		}
		values[i] = flag == 1
	}
	return values, nil
}
