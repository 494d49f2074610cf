package procgenclient

import "math/bits"

// The tables of an encoded answer's content (procgen/v1/pools.proto, Encoding), and how far blocks have been read.
type content struct {
	ages       []byte
	advances   []byte
	changed    []byte
	down       []byte
	right      []byte
	mendedRows []byte
	masks      []byte
	values     []byte

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
			return nil, damaged("a block changes that the picture has not")
		}
	}
	blocks := countBits(c.changed)
	c.down = take(blocks)
	c.right = take(blocks)
	c.mendedRows = take(blocks)
	c.masks = take(countBits(c.mendedRows))
	c.values = take(countBits(c.masks) * pixelBytes)
	if ends {
		return nil, damaged("they end in the midst of a table")
	}
	if len(bytes) > 0 {
		return nil, damaged("there are %d bytes too many", len(bytes))
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
	return int(int8(c.down[block])), int(int8(c.right[block])), c.mendedRows[block]
}

// Puts the next values where the next mask says, in a row of a block.
func (c *content) mendRow(row []byte) {
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
