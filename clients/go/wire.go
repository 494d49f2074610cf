package procgenclient

import (
	"encoding/binary"
	"errors"
	"math"

	"google.golang.org/protobuf/encoding/protowire"
	"google.golang.org/protobuf/proto"

	pb "procgenclient/procgenv1"
)

// Fields of StepPoolResponse and Batch that are read here (proto/procgen/v1/step.proto).
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

// What messages are written and read with, by whatever Protocol Buffers the gRPC that is linked is made for (Debian's is older
// than the generated code).
//
// Responses of StepPool are read here: Protocol Buffers would copy every observation, but on the wire each array of a batch
// is the little-endian array itself (proto/README.md, "On the wire"), so a slice of the received bytes will do. What is
// written in another way than a server of today writes it (unpacked, or in several pieces: both allowed by Protocol Buffers)
// goes the long way through the generated message.
type codec struct{}

// Name is that of the encoding on the wire.
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

// A StepPoolResponse: a part if it bears a batch, else the message itself.
type response struct {
	part    *part
	message *pb.StepPoolResponse
}

var errOtherwiseWritten = errors.New("not written as it is read here")

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

// The slow and obvious way, by the generated message.
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

// Calls `use` with each field of a message: its bytes, or its number where it is a varint.
func eachField(message []byte, use func(field protowire.Number, bytes []byte, number uint64) error) error {
	seen := map[protowire.Number]bool{}
	for len(message) > 0 {
		field, kind, size := protowire.ConsumeTag(message)
		if size < 0 || seen[field] {
			return errOtherwiseWritten
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
			return errOtherwiseWritten
		}
		if size < 0 {
			return errOtherwiseWritten
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
		return errOtherwiseWritten
	})
	if err == nil && !found {
		err = errOtherwiseWritten
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
		return errOtherwiseWritten // It has no pictures, so the long way is short.
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
	return err // Anything else is a field of a later server, which clients ignore.
}

func floats(bytes []byte) ([]float32, error) {
	if len(bytes)%4 != 0 {
		return nil, errOtherwiseWritten
	}
	values := make([]float32, len(bytes)/4)
	for i := range values {
		values[i] = math.Float32frombits(binary.LittleEndian.Uint32(bytes[4*i:]))
	}
	return values, nil
}

func integers(bytes []byte) ([]int32, error) {
	if len(bytes)%4 != 0 {
		return nil, errOtherwiseWritten
	}
	values := make([]int32, len(bytes)/4)
	for i := range values {
		values[i] = int32(binary.LittleEndian.Uint32(bytes[4*i:]))
	}
	return values, nil
}

func hashes(bytes []byte) ([]uint64, error) {
	if len(bytes)%8 != 0 {
		return nil, errOtherwiseWritten
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
			return nil, errOtherwiseWritten // A longer varint.
		}
		values[i] = flag == 1
	}
	return values, nil
}
