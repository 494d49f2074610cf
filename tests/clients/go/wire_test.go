package procgenclient

// The parser of responses equals the generated message, for any valid wire form.

import (
	"reflect"
	"testing"

	"google.golang.org/protobuf/encoding/protowire"
	"google.golang.org/protobuf/proto"

	pb "procgenclient/procgenv1"
)

func aResponse() *pb.StepPoolResponse {
	return &pb.StepPoolResponse{SequenceNumber: 7, Response: &pb.StepPoolResponse_Batch{Batch: &pb.Batch{
		FirstEnv: 3, EnvCount: 2, Last: true,
		Rewards: []float32{0, 10.5}, First: []bool{true, false}, Terminated: []bool{false, true}, Truncated: []bool{false, false},
		LevelSeeds: []int32{-1, 1 << 30}, PrevLevelSeeds: []int32{4, 5}, PrevLevelComplete: []bool{false, true},
		EpisodeReturns: []float32{1, -2}, EpisodeLengths: []int32{8, 9}, Fingerprints: []int64{-5},
		FinalObservations: []byte{1, 2, 3}, Observations: []byte{4, 5, 6, 7, 8, 9},
	}}}
}

func TestResponsesAreParsedLikeTheGeneratedMessage(t *testing.T) {
	message := aResponse()
	bytes, err := proto.Marshal(message)
	must(t, err)
	read, err := readBatchResponse(bytes)
	must(t, err)
	if expected := partOf(7, message.GetBatch()); !reflect.DeepEqual(read, expected) {
		t.Errorf("%+v, where %+v is expected", read, expected)
	}
	if read.Fingerprints[0] != 1<<64-5 {
		t.Error(read.Fingerprints)
	}
}

func TestResponsesOfLaterAndOtherServersAreParsed(t *testing.T) {
	batch, err := proto.Marshal(aResponse().GetBatch())
	must(t, err)
	batch = protowire.AppendTag(batch, 999, protowire.VarintType)
	batch = protowire.AppendVarint(batch, 1)
	unpacked := protowire.AppendTag(append([]byte(nil), batch...), rewardsField, protowire.Fixed32Type)
	unpacked = protowire.AppendFixed32(unpacked, 0x3f800000)
	for _, bytes := range [][]byte{batch, unpacked} {
		message := protowire.AppendTag(nil, sequenceNumberField, protowire.VarintType)
		message = protowire.AppendVarint(message, 7)
		message = protowire.AppendTag(message, batchField, protowire.BytesType)
		message = protowire.AppendBytes(message, bytes)
		var expected pb.Batch
		must(t, proto.Unmarshal(bytes, &expected))
		var read response
		must(t, read.read(message))
		if !reflect.DeepEqual(read.part.Rewards, expected.Rewards) {
			t.Error(read.part.Rewards, expected.Rewards)
		}
	}
	var read response
	if read.read([]byte{0xff, 0xff}) == nil {
		t.Error("an invalid message was parsed")
	}
}
