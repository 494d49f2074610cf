package procgenclient

// Encoded observations decode to the raw ones, and damage is detected.

import (
	"bytes"
	"testing"

	"github.com/klauspost/compress/zstd"
	"google.golang.org/grpc/codes"
	"google.golang.org/protobuf/proto"

	pb "procgenclient/procgenv1"
)

func TestEncodedObservationsAreLossless(t *testing.T) {
	client := connected(t, Options{})
	for name, format := range map[string]*pb.ObservationFormat{
		"default": nil,
		"grey":    {Color: pb.Color_COLOR_GRAYSCALE, SizePx: 84, FrameStack: 4},
		"planes":  {Layout: pb.Layout_LAYOUT_CHW, SizePx: 21, FrameStack: 2},
	} {
		t.Run(name, func(t *testing.T) {
			spec := easy(6, "bigfish", "jumper", "maze")
			spec.ObservationFormat = format
			raw := madePool(t, client, spec, PoolOptions{})
			encoded := proto.Clone(spec).(*pb.PoolSpec)
			encoded.Encoding = pb.Encoding_ENCODING_DELTA_ZSTD
			encodedPool := madePool(t, client, encoded, PoolOptions{})
			for step := 0; step < 80; step++ {
				if step == 40 {
					encodedPool.Detach(testContext(t)) // The next stream starts with key frames.
				}
				expected := stepped(t, raw, actionsOf(step, 6), StepOptions{})
				batch := stepped(t, encodedPool, actionsOf(step, 6), StepOptions{})
				if !bytes.Equal(batch.Observations, expected.Observations) {
					t.Fatalf("step %d differs", step)
				}
			}
		})
	}
}

func zstdFrame(t *testing.T, content ...byte) []byte {
	encoder, err := zstd.NewWriter(nil, zstd.WithSingleSegment(true))
	must(t, err)
	return encoder.EncodeAll(content, nil)
}

// One environment of 2 x 2 grayscale blocks.
func decoder(t *testing.T) *ObservationDecoder {
	decoder, err := NewObservationDecoder(&pb.Pool{Spec: &pb.PoolSpec{
		EnvCount:          1,
		Encoding:          pb.Encoding_ENCODING_DELTA_ZSTD,
		ObservationFormat: &pb.ObservationFormat{Color: pb.Color_COLOR_GRAYSCALE, SizePx: 16},
	}})
	must(t, err)
	return decoder
}

// Age, changed, down, right, rows, masks, values.
var onePixel = []byte{0, 0b0001, 0, 0, 0b10, 0b100, 77}

func TestTablesMatchTheProto(t *testing.T) {
	decoder := decoder(t)
	shown, err := decoder.Decode(0, 1, zstdFrame(t, onePixel...))
	must(t, err)
	expected := make([]byte, 256)
	expected[16+2] = 77
	if !bytes.Equal(shown, expected) {
		t.Error(shown)
	}
	// The block is shifted down by one row and right by two pixels.
	moved, err := decoder.Decode(0, 1, zstdFrame(t, 1, 0b0001, 1, 2, 0))
	must(t, err)
	if moved[0] != 77 {
		t.Error(moved[:16])
	}
	_, err = decoder.Decode(0, 1, zstdFrame(t, 3, 0))
	expectError(t, err, codes.FailedPrecondition, "has age 3, expected: 2 or 0")
	_, err = decoder.Decode(0, 1, zstdFrame(t, 2, 0))
	must(t, err)
}

func TestDamagedObservationsAreDetected(t *testing.T) {
	whole := zstdFrame(t, onePixel...)
	for what, frame := range map[string][]byte{
		"a table that ends":          zstdFrame(t, onePixel[:5]...),
		"bytes too many":             zstdFrame(t, append(onePixel, 0)...),
		"a block beyond the picture": zstdFrame(t, 0, 0b10000, 0, 0, 0),
		"a row without pixels":       zstdFrame(t, 0, 1, 0, 0, 1, 0),
		"a frame that is cut off":    whole[:len(whole)-1],
		"two frames":                 append(append([]byte(nil), whole...), whole...),
		"no frame":                   []byte("no frame of any kind"),
		"more than there can be":     zstdFrame(t, make([]byte, 10000)...),
	} {
		t.Run(what, func(t *testing.T) {
			_, err := decoder(t).Decode(0, 1, frame)
			expectError(t, err, codes.DataLoss)
		})
	}
}
