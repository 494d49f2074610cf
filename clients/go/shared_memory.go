package procgenclient

import (
	"fmt"
	"os"
	"sync"
	"syscall"

	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

// Element types of the arrays of a batch.
var sharedElements = map[string]pb.ElementType{
	"rewards":             pb.ElementType_ELEMENT_TYPE_FLOAT32,
	"first":               pb.ElementType_ELEMENT_TYPE_BOOL,
	"terminated":          pb.ElementType_ELEMENT_TYPE_BOOL,
	"truncated":           pb.ElementType_ELEMENT_TYPE_BOOL,
	"level_seeds":         pb.ElementType_ELEMENT_TYPE_INT32,
	"prev_level_seeds":    pb.ElementType_ELEMENT_TYPE_INT32,
	"prev_level_complete": pb.ElementType_ELEMENT_TYPE_BOOL,
	"episode_returns":     pb.ElementType_ELEMENT_TYPE_FLOAT32,
	"episode_lengths":     pb.ElementType_ELEMENT_TYPE_INT32,
	"fingerprints":        pb.ElementType_ELEMENT_TYPE_INT64,
	"final_observations":  pb.ElementType_ELEMENT_TYPE_UINT8,
	"observations":        pb.ElementType_ELEMENT_TYPE_UINT8,
}

var elementBytes = map[pb.ElementType]int64{
	pb.ElementType_ELEMENT_TYPE_UINT8:   1,
	pb.ElementType_ELEMENT_TYPE_BOOL:    1,
	pb.ElementType_ELEMENT_TYPE_INT32:   4,
	pb.ElementType_ELEMENT_TYPE_INT64:   8,
	pb.ElementType_ELEMENT_TYPE_FLOAT32: 4,
}

type sharedArray struct{ offset, rowBytes int64 }

// The memory that a pool shares (SharedMemory in step.proto), and the batches of it that are held.
// It stays mapped after the pool has gone until all batches are released, because slices of it may
// be in use.
type sharedMemory struct {
	message *pb.SharedMemory
	arrays  map[string]sharedArray
	bytes   []byte

	mutex    sync.Mutex // Guards the fields below: batches are released from any goroutine.
	held     map[int32]bool
	released []int32
	mapped   [][]byte // All mappings, also those from before the file grew.
	left     bool     // The pool does not use it any more.
}

// A batch that the server does not overwrite until it is released.
type heldBatch struct {
	memory *sharedMemory
	number int32
}

// Maps the shared memory. `before` is the mapping of earlier streams of the pool, or nil, which is
// returned unchanged after an error.
func mapShared(message *pb.SharedMemory, pool *pb.Pool, before *sharedMemory) (*sharedMemory, error) {
	if before != nil && before.message.Path != message.Path {
		return before, newError(codes.Aborted, "the server shares %s, and the pool of the same name shared %s before: it is "+
			"another pool", message.Path, before.message.Path)
	}
	if before != nil && before.message.BatchCount == message.BatchCount {
		return before, nil
	}
	memory := before
	if memory == nil {
		memory = &sharedMemory{held: map[int32]bool{}}
	}
	arrays, err := readArrays(message, pool)
	if err != nil {
		return before, err
	}
	bytes, err := mapFile(message.Path, message.SizeBytes)
	if err != nil {
		return before, newError(codes.FailedPrecondition, "cannot map the pool's shared memory %s: %v; it can be mapped on the "+
			"server's machine (and in its container), by its user; elsewhere make the pool with TRANSPORT_STREAM", message.Path, err)
	}
	memory.message, memory.arrays, memory.bytes = message, arrays, bytes
	memory.mapped = append(memory.mapped, bytes)
	return memory, nil
}

func mapFile(path string, sizeBytes int64) ([]byte, error) {
	// O_NONBLOCK: opening a FIFO must not block.
	file, err := os.OpenFile(path, os.O_RDONLY|syscall.O_NONBLOCK, 0)
	if err != nil {
		return nil, err
	}
	defer file.Close()
	facts, err := file.Stat()
	if err != nil {
		return nil, err
	}
	// Reading a mapping beyond the end of the file raises SIGBUS.
	if !facts.Mode().IsRegular() || facts.Size() < sizeBytes {
		return nil, fmt.Errorf("it has %d bytes, expected: a regular file of %d", facts.Size(), sizeBytes)
	}
	return syscall.Mmap(int(file.Fd()), 0, int(sizeBytes), syscall.PROT_READ, syscall.MAP_SHARED)
}

// Returns the position of each array. Each has a row for each environment of the pool.
func readArrays(message *pb.SharedMemory, pool *pb.Pool) (map[string]sharedArray, error) {
	wrong := func(what string) (map[string]sharedArray, error) {
		return nil, newError(codes.Internal, "the server's shared memory %s %s", message.Path, what)
	}
	if message.BatchCount < 1 || message.BatchBytes < 1 || message.SizeBytes/int64(message.BatchCount) != message.BatchBytes ||
		message.SizeBytes%message.BatchBytes != 0 {
		return wrong("has inconsistent sizes")
	}
	arrays, envCount := map[string]sharedArray{}, int64(pool.Spec.EnvCount)
	for _, array := range message.Arrays {
		kind, known := sharedElements[array.Field]
		if !known {
			continue // An unknown array, which clients ignore.
		}
		row, shape := elementBytes[kind], []int32{pool.Spec.EnvCount}
		if kind == pb.ElementType_ELEMENT_TYPE_UINT8 {
			row, shape = int64(pool.ObservationBytes), append(shape, pool.ObservationShape...)
		}
		if kind != array.ElementType || fmt.Sprint(array.Shape) != fmt.Sprint(shape) {
			return wrong("has no array " + array.Field + " of its type and of shape " + fmt.Sprint(shape))
		}
		offset := array.OffsetBytes
		if offset < 0 || offset%64 != 0 || offset > message.BatchBytes || row > (message.BatchBytes-offset)/envCount {
			return wrong("has an array " + array.Field + " that does not fit")
		}
		arrays[array.Field] = sharedArray{offset, row}
	}
	if len(arrays) != len(sharedElements) {
		return wrong("has not all arrays")
	}
	return arrays, nil
}

// Sets the arrays of a part: observations are slices of the memory, numbers are copies. The part is
// validated, except for its batch.
func (m *sharedMemory) hold(p *part) error {
	number, first, count := p.shared.number, int64(p.FirstEnv), int64(p.count)
	m.mutex.Lock()
	isHeld := m.held[number]
	m.mutex.Unlock()
	if number < 0 || number >= m.message.BatchCount || isHeld {
		return newError(codes.Internal, "the server answers in batch %d of shared memory, expected: one of %d that is not held",
			number, m.message.BatchCount)
	}
	rows := func(field string, rowCount int64) []byte {
		array := m.arrays[field]
		begin := int64(number)*m.message.BatchBytes + array.offset + first*array.rowBytes
		return m.bytes[begin : begin+rowCount*array.rowBytes : begin+rowCount*array.rowBytes]
	}
	flag := func(field string) []bool {
		values := make([]bool, count)
		for i, value := range rows(field, count) {
			values[i] = value != 0
		}
		return values
	}
	p.Rewards, _ = floats(rows("rewards", count)) // No errors: all sizes are multiples of the element size.
	p.First, p.Terminated, p.Truncated = flag("first"), flag("terminated"), flag("truncated")
	p.LevelSeeds, _ = integers(rows("level_seeds", count))
	p.PrevLevelSeeds, _ = integers(rows("prev_level_seeds", count))
	p.PrevLevelComplete = flag("prev_level_complete")
	p.EpisodeReturns, _ = floats(rows("episode_returns", count))
	p.EpisodeLengths, _ = integers(rows("episode_lengths", count))
	ended := int64(0)
	for i := range p.Terminated {
		if p.Terminated[i] || p.Truncated[i] {
			ended++
		}
	}
	p.Fingerprints = nil
	if ended > 0 {
		p.Fingerprints, _ = hashes(rows("fingerprints", ended))
	}
	if p.shared.finals && ended > 0 {
		p.FinalObservations = rows("final_observations", ended)
	}
	if p.shared.observations {
		p.Observations = rows("observations", count)
	}
	m.mutex.Lock()
	defer m.mutex.Unlock()
	m.held[number] = true
	p.held = &heldBatch{m, number}
	return nil
}

func (h *heldBatch) release() {
	h.memory.mutex.Lock()
	defer h.memory.mutex.Unlock()
	delete(h.memory.held, h.number)
	h.memory.released = append(h.memory.released, h.number)
	h.memory.unmapIfDone()
}

func (m *sharedMemory) heldCount() int {
	m.mutex.Lock()
	defer m.mutex.Unlock()
	return len(m.held)
}

// Returns the batches released since the last call.
func (m *sharedMemory) takeReleased() []int32 {
	m.mutex.Lock()
	defer m.mutex.Unlock()
	released := m.released
	m.released = nil
	return released
}

// Returns the batches held, for Attach.held_batches, and clears the released ones, which attaching
// releases.
func (m *sharedMemory) takeHeld() []int32 {
	m.mutex.Lock()
	defer m.mutex.Unlock()
	m.released = nil
	var held []int32
	for number := range m.held {
		held = append(held, number)
	}
	return held
}

// Marks the memory as unused by the pool.
func (m *sharedMemory) leave() {
	m.mutex.Lock()
	defer m.mutex.Unlock()
	m.left = true
	m.unmapIfDone()
}

func (m *sharedMemory) unmapIfDone() {
	if !m.left || len(m.held) > 0 {
		return
	}
	for _, bytes := range m.mapped {
		_ = syscall.Munmap(bytes) // Cannot fail for a slice from Mmap.
	}
	m.mapped = nil
}
