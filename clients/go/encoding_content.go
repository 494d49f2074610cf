package procgenclient

import "math/bits"

// The tables of a zstd frame's content (procgen/v1/pools.proto, Encoding), and the read position in
// those of the blocks.
type content struct {
	ages        []byte
	advances    []byte
	changed     []byte
	down        []byte
	right       []byte
	patchedRows []byte
	masks       []byte
	values      []byte

	pixelBytes int
	mapBytes   int
	block      int
	mask       int
	value      int
}

func readContent(bytes []byte, count, stack, blockCount, pixelBytes int) (*content, error) {
	c := &content{pixelBytes: pixelBytes, mapBytes: (blockCount + 7) / 8}
	ends := false
	take := func(size int) []byte {
		if size > len(bytes) {
			ends = true
			return nil
		}
		taken := bytes[:size]
		bytes = bytes[size:]
		return taken
	}
	c.ages = take(count)
	if stack > 1 {
		c.advances = take(count)
	}
	c.changed = take(count * c.mapBytes)
	lastBits := blockCount - (c.mapBytes-1)*8
	for i := c.mapBytes - 1; i < len(c.changed); i += c.mapBytes {
		if c.changed[i]>>lastBits != 0 {
			return nil, damaged("a block outside the observation changes")
		}
	}
	blocks := countBits(c.changed)
	c.down = take(blocks)
	c.right = take(blocks)
	c.patchedRows = take(blocks)
	c.masks = take(countBits(c.patchedRows))
	c.values = take(countBits(c.masks) * pixelBytes)
	if ends {
		return nil, damaged("truncated within a table")
	}
	if len(bytes) > 0 {
		return nil, damaged("%d bytes too many", len(bytes))
	}
	return c, nil
}

func (c *content) advance(row int) int {
	if c.advances == nil {
		return 0
	}
	return int(c.advances[row])
}

func (c *content) isChanged(row, block int) bool {
	return c.changed[row*c.mapBytes+block/8]>>(block%8)&1 != 0
}

func (c *content) nextBlock() (down, right int, rows byte) {
	block := c.block
	c.block++
	return int(int8(c.down[block])), int(int8(c.right[block])), c.patchedRows[block]
}

// Writes the next values at each set bit of the next mask, in a row of a block.
func (c *content) patchRow(row []byte) {
	mask := c.masks[c.mask]
	c.mask++
	for ; mask != 0; mask >>= 1 {
		if mask&1 != 0 {
			c.value += copy(row[:c.pixelBytes], c.values[c.value:])
		}
		if mask > 1 {
			row = row[c.pixelBytes:]
		}
	}
}

func countBits(bytes []byte) int {
	count := 0
	for _, b := range bytes {
		count += bits.OnesCount8(b)
	}
	return count
}
