package procgenclient

import (
	"fmt"
	"os"
	"sync"
	"syscall"

	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

// The arrays of a batch, and what their elements are.
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

// The memory that a pool shares (proto: SharedMemory), and which batches of it are held. It is mapped for good once a
// batch of it is not released when the pool lets it go: slices of it may be in use.
type sharedMemory struct {
	told   *pb.SharedMemory
	arrays map[string]sharedArray
	bytes  []byte

	mutex    sync.Mutex // Of what follows: batches are released from any goroutine.
	held     map[int32]bool
	released []int32
	mapped   [][]byte // Also what was mapped before the file grew.
	left     bool     // By the pool.
}

// A batch that the server does not write until it is released.
type heldBatch struct {
	memory *sharedMemory
	number int32
}

// Maps what the server tells of; `before` is what was mapped by earlier streams of the pool, or nil, and stays so after an
// error.
func mapShared(told *pb.SharedMemory, pool *pb.Pool, before *sharedMemory) (*sharedMemory, error) {
	if before != nil && before.told.Path != told.Path {
		return before, newError(codes.Aborted, "the server shares %s, and what was attached to before shares %s: it is another "+
			"pool of the same name", told.Path, before.told.Path)
	}
	if before != nil && before.told.BatchCount == told.BatchCount {
		return before, nil
	}
	memory := before
	if memory == nil {
		memory = &sharedMemory{held: map[int32]bool{}}
	}
	arrays, err := readArrays(told, pool)
	if err != nil {
		return before, err
	}
	bytes, err := mapFile(told.Path, told.SizeBytes)
	if err != nil {
		return before, newError(codes.FailedPrecondition, "cannot map the pool's shared memory %s: %v; it can be mapped on the "+
			"server's machine (and in its container), by its user; elsewhere make the pool with TRANSPORT_STREAM", told.Path, err)
	}
	memory.told, memory.arrays, memory.bytes = told, arrays, bytes
	memory.mapped = append(memory.mapped, bytes)
	return memory, nil
}

func mapFile(path string, sizeBytes int64) ([]byte, error) {
	// Opening a pipe must not wait for somebody to write to it.
	file, err := os.OpenFile(path, os.O_RDONLY|syscall.O_NONBLOCK, 0)
	if err != nil {
		return nil, err
	}
	defer file.Close()
	facts, err := file.Stat()
	if err != nil {
		return nil, err
	}
	// What lies behind the end of a file cannot be read, and ends who tries.
	if !facts.Mode().IsRegular() || facts.Size() < sizeBytes {
		return nil, fmt.Errorf("it has %d bytes and is no file of %d", facts.Size(), sizeBytes)
	}
	return syscall.Mmap(int(file.Fd()), 0, int(sizeBytes), syscall.PROT_READ, syscall.MAP_SHARED)
}

// Where each array is, which has a row for each environment of the pool.
func readArrays(told *pb.SharedMemory, pool *pb.Pool) (map[string]sharedArray, error) {
	wrong := func(what string) (map[string]sharedArray, error) {
		return nil, newError(codes.Internal, "the server's shared memory %s %s", told.Path, what)
	}
	if told.BatchCount < 1 || told.BatchBytes < 1 || told.SizeBytes/int64(told.BatchCount) != told.BatchBytes ||
		told.SizeBytes%told.BatchBytes != 0 {
		return wrong("is not told as a whole")
	}
	arrays, envCount := map[string]sharedArray{}, int64(pool.Spec.EnvCount)
	for _, array := range told.Arrays {
		kind, known := sharedElements[array.Field]
		if !known {
			continue // Of a later server.
		}
		row, shape := elementBytes[kind], []int32{pool.Spec.EnvCount}
		if kind == pb.ElementType_ELEMENT_TYPE_UINT8 {
			row, shape = int64(pool.ObservationBytes), append(shape, pool.ObservationShape...)
		}
		if kind != array.ElementType || fmt.Sprint(array.Shape) != fmt.Sprint(shape) {
			return wrong("has no array " + array.Field + " of its type and of shape " + fmt.Sprint(shape))
		}
		offset := array.OffsetBytes
		if offset < 0 || offset%64 != 0 || offset > told.BatchBytes || row > (told.BatchBytes-offset)/envCount {
			return wrong("has an array " + array.Field + " that does not fit")
		}
		arrays[array.Field] = sharedArray{offset, row}
	}
	if len(arrays) != len(sharedElements) {
		return wrong("lacks an array")
	}
	return arrays, nil
}

// Gives a part its arrays: pictures are the memory itself, numbers are copies. The part was checked, but for its batch.
func (m *sharedMemory) hold(p *part) error {
	number, first, count := p.shared.number, int64(p.FirstEnv), int64(p.count)
	m.mutex.Lock()
	isHeld := m.held[number]
	m.mutex.Unlock()
	if number < 0 || number >= m.told.BatchCount || isHeld {
		return newError(codes.Internal, "the server answers in batch %d of shared memory, expected: one of %d that is not held",
			number, m.told.BatchCount)
	}
	rows := func(field string, rowCount int64) []byte {
		array := m.arrays[field]
		begin := int64(number)*m.told.BatchBytes + array.offset + first*array.rowBytes
		return m.bytes[begin : begin+rowCount*array.rowBytes : begin+rowCount*array.rowBytes]
	}
	flag := func(field string) []bool {
		values := make([]bool, count)
		for i, value := range rows(field, count) {
			values[i] = value != 0
		}
		return values
	}
	p.Rewards, _ = floats(rows("rewards", count)) // All are of whole elements.
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

// What was released since this was asked the last time.
func (m *sharedMemory) takeReleased() []int32 {
	m.mutex.Lock()
	defer m.mutex.Unlock()
	released := m.released
	m.released = nil
	return released
}

// All that are held, to be told as a whole.
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

// The pool needs it no more.
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
		_ = syscall.Munmap(bytes) // It cannot fail: it is what Mmap gave.
	}
	m.mapped = nil
}
