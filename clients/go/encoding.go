package procgenclient

import (
	"math/bits"

	"github.com/klauspost/compress/zstd"
	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

const blockSide = 8      // Side of a block, in rows and pixels.
const sizePxDefault = 64 // Side of a frame.
const decoderMemoryMin = 1 << 20

// Returns the decoder for a pool's observations; nil if they are not encoded.
func decoderFor(pool *pb.Pool) (*ObservationDecoder, error) {
	switch pool.Spec.Encoding {
	case pb.Encoding_ENCODING_UNSPECIFIED, pb.Encoding_ENCODING_RAW:
		return nil, nil
	}
	return NewObservationDecoder(pool)
}

// ObservationDecoder decodes ENCODING_DELTA_ZSTD; the comment of Encoding in procgen/v1/pools.proto
// defines the bytes. Observations must be decoded once each, in the order of sequence numbers,
// without gaps. The decoder keeps the last observation of each environment, and is unchanged after
// an error. A Pool uses one by itself.
type ObservationDecoder struct {
	rows, columns, pixelBytes, stack int

	zstd  *zstd.Decoder
	ages  []byte // The next age of each environment; 0: only a key frame may follow.
	shown []byte // The last observation of each environment, [N * F].
	basis []byte // Scratch: the observation that a delta refers to, [F].
}

// NewObservationDecoder returns a decoder for a pool. INVALID_ARGUMENT: an unknown encoding.
func NewObservationDecoder(pool *pb.Pool) (*ObservationDecoder, error) {
	spec := pool.Spec
	if spec.Encoding != pb.Encoding_ENCODING_DELTA_ZSTD {
		return nil, invalid("encoding is %v, allowed: ENCODING_DELTA_ZSTD", spec.Encoding)
	}
	format := spec.GetObservationFormat()
	sizePx := int(format.GetSizePx())
	if sizePx == 0 {
		sizePx = sizePxDefault
	}
	d := &ObservationDecoder{columns: sizePx, pixelBytes: 3, stack: clamp(int(format.GetFrameStack()), 1, 16)}
	if format.GetColor() == pb.Color_COLOR_GRAYSCALE {
		d.pixelBytes = 1
	}
	d.rows = sizePx * d.stack
	if format.GetLayout() == pb.Layout_LAYOUT_CHW {
		d.rows, d.pixelBytes = d.rows*d.pixelBytes, 1
	}
	observationBytes := d.rows * d.columns * d.pixelBytes
	d.ages = make([]byte, spec.EnvCount)
	d.shown = make([]byte, int(spec.EnvCount)*observationBytes)
	d.basis = make([]byte, observationBytes)
	var err error
	// The library needs more memory than the content, and at least decoderMemoryMin.
	memoryMax := uint64(d.contentBytesMax(len(d.ages)) + decoderMemoryMin)
	d.zstd, err = zstd.NewReader(nil, zstd.WithDecoderConcurrency(1), zstd.WithDecoderMaxMemory(memoryMax))
	return d, err
}

// Decode decodes the observations of the environments [first, first + count), [count * F].
// INVALID_ARGUMENT: environments out of range. DATA_LOSS: malformed bytes. FAILED_PRECONDITION: a
// gap, earlier observations are missing or these were decoded before.
func (d *ObservationDecoder) Decode(first, count int, encoded []byte) ([]byte, error) {
	if first < 0 || count < 1 || first+count > len(d.ages) {
		return nil, invalid("%d environments from %d, the pool has %d", count, first, len(d.ages))
	}
	bytes, err := d.frameContent(encoded, d.contentBytesMax(count))
	if err != nil {
		return nil, err
	}
	content, err := d.read(first, count, bytes)
	if err != nil {
		return nil, err
	}
	size := len(d.basis)
	observations := make([]byte, count*size)
	for i := 0; i < count; i++ {
		shown := d.shown[(first+i)*size : (first+i+1)*size]
		age := content.ages[i]
		d.writeBasis(shown, age, content.advance(i))
		observation := observations[i*size : (i+1)*size]
		copy(observation, d.basis)
		for block := 0; block < d.blockCount(); block++ {
			if content.isChanged(i, block) {
				d.decodeBlock(block, content, observation)
			}
		}
		copy(shown, observation)
		if d.ages[first+i] = age + 1; age == 255 {
			d.ages[first+i] = 1
		}
	}
	return observations, nil
}

func (d *ObservationDecoder) blockColumns() int { return (d.columns + blockSide - 1) / blockSide }

func (d *ObservationDecoder) blockCount() int {
	return (d.rows + blockSide - 1) / blockSide * d.blockColumns()
}

func (d *ObservationDecoder) contentBytesMax(count int) int {
	numbers := 2 + (d.blockCount()+7)/8 + d.blockCount()*(3+blockSide)
	return count * (numbers + len(d.basis))
}

func (d *ObservationDecoder) frameContent(frame []byte, bytesMax int) ([]byte, error) {
	var header zstd.Header
	if err := header.Decode(frame); err != nil || header.Skippable || !header.HasFCS {
		return nil, damaged("no zstd frame with a content size")
	}
	if header.FrameContentSize > uint64(bytesMax) {
		return nil, damaged("content of %d bytes, expected: at most %d", header.FrameContentSize, bytesMax)
	}
	content, err := d.zstd.DecodeAll(frame, make([]byte, 0, header.FrameContentSize))
	if err != nil {
		return nil, damaged("not one complete zstd frame: %v", err)
	}
	if uint64(len(content)) != header.FrameContentSize {
		return nil, damaged("content of %d bytes, expected: %d", len(content), header.FrameContentSize)
	}
	return content, nil
}

func (d *ObservationDecoder) read(first, count int, bytes []byte) (*content, error) {
	c, err := readContent(bytes, count, d.stack, d.blockCount(), d.pixelBytes)
	if err != nil {
		return nil, err
	}
	for i, age := range c.ages {
		if expected := d.ages[first+i]; age != 0 && age != expected {
			return nil, newError(codes.FailedPrecondition, "encoded observations: environment %d has age %d, expected: %d or 0; "+
				"answers are missing or came twice", first+i, age, expected)
		}
		if advance := c.advance(i); advance >= d.stack || age == 0 && advance != 0 {
			return nil, damaged("a stack of %d moves by %d", d.stack, advance)
		}
	}
	return c, d.checkInside(c)
}

// Checks that nothing outside the plane is patched; blocks in the last row and column may be
// smaller.
func (d *ObservationDecoder) checkInside(c *content) error {
	changed, patched := 0, 0
	for i := range c.ages {
		for block := 0; block < d.blockCount(); block++ {
			if !c.isChanged(i, block) {
				continue
			}
			_, _, height, width := d.place(block)
			rows := c.patchedRows[changed]
			changed++
			if rows>>height != 0 {
				return damaged("a row outside the observation is patched")
			}
			for row := bits.OnesCount8(rows); row > 0; row-- {
				mask := c.masks[patched]
				patched++
				if mask == 0 || mask>>width != 0 {
					return damaged("a patched row has no patched pixel, or one outside the observation")
				}
			}
		}
	}
	return nil
}

func (d *ObservationDecoder) place(block int) (row, column, height, width int) {
	row = block / d.blockColumns() * blockSide
	column = block % d.blockColumns() * blockSide
	return row, column, clamp(d.rows-row, 0, blockSide), clamp(d.columns-column, 0, blockSide)
}

func (d *ObservationDecoder) writeBasis(shown []byte, age byte, advance int) {
	frameBytes := len(d.basis) / d.stack
	for place := 0; place < d.stack; place++ {
		frame := d.basis[place*frameBytes : (place+1)*frameBytes]
		if age == 0 {
			zero(frame)
			continue
		}
		from := clamp(place+advance, 0, d.stack-1) * frameBytes
		copy(frame, shown[from:from+frameBytes])
	}
}

func (d *ObservationDecoder) decodeBlock(block int, c *content, observation []byte) {
	row, column, height, width := d.place(block)
	down, right, rows := c.nextBlock()
	rowBytes := d.columns * d.pixelBytes
	for y := 0; y < height; y++ {
		from := d.basis[clamp(row+y+down, 0, d.rows-1)*rowBytes:]
		to := observation[(row+y)*rowBytes+column*d.pixelBytes:]
		for x := 0; x < width; x++ {
			pixel := clamp(column+x+right, 0, d.columns-1) * d.pixelBytes
			copy(to[x*d.pixelBytes:], from[pixel:pixel+d.pixelBytes])
		}
		if rows>>y&1 != 0 {
			c.patchRow(to)
		}
	}
}

func zero(bytes []byte) {
	for i := range bytes {
		bytes[i] = 0
	}
}

func damaged(format string, arguments ...interface{}) error {
	return newError(codes.DataLoss, "encoded observations: "+format, arguments...)
}
