package procgenclient

// Pools in shared memory: batches equal those of the stream and are valid until they are released;
// nothing leaks.

import (
	"bytes"
	"os"
	"path/filepath"
	"reflect"
	"strings"
	"testing"

	"google.golang.org/grpc/codes"
	"google.golang.org/protobuf/proto"

	pb "procgenclient/procgenv1"
)

func sharing(spec *pb.PoolSpec) *pb.PoolSpec {
	spec.Transport = pb.Transport_TRANSPORT_SHARED_MEMORY
	return spec
}

// A copy of a batch outside shared memory.
func owned(batch *Batch) *Batch {
	own := *batch
	own.Observations = append([]byte(nil), batch.Observations...)
	own.FinalObservations = append([]byte(nil), batch.FinalObservations...)
	own.held = nil
	batch.Release()
	return &own
}

// How many mappings of pool files this process has.
func mappings(t *testing.T) int {
	maps, err := os.ReadFile("/proc/self/maps")
	must(t, err)
	return strings.Count(string(maps), "procgen-server-")
}

func TestSharedBatchesEqualThoseOfTheStream(t *testing.T) {
	client := connected(t, Options{})
	plain := madePool(t, client, easy(4, "maze", "bigfish"), PoolOptions{})
	shared := madePool(t, client, sharing(easy(4, "maze", "bigfish")), PoolOptions{})
	for step := 0; step < 80; step++ {
		options := StepOptions{FinalObservations: step%2 == 0, Blind: step%5 == 4, FirstEnv: step % 3}
		actions := actionsOf(step, 4-step%3)
		expected, batch := stepped(t, plain, actions, options), stepped(t, shared, actions, options)
		if len(batch.Observations) > 0 && batch.held == nil {
			t.Fatal("the pool has no shared memory")
		}
		if !reflect.DeepEqual(owned(batch), expected) {
			t.Fatalf("step %d differs", step)
		}
	}
}

func TestSharedBatchesStayUntilTheyAreReleased(t *testing.T) {
	ctx := testContext(t)
	pool := madePool(t, connected(t, Options{}), sharing(easy(4, "maze")), PoolOptions{HeldBatchesMax: 3})
	var held []*Batch
	var content [][]byte
	for step := 0; step < 5; step++ { // Three held ones, plus requests in flight.
		batch := stepped(t, pool, actionsOf(step, 4), StepOptions{})
		held = append(held, batch)
		content = append(content, append([]byte(nil), batch.Observations...))
	}
	_, err := pool.Step(ctx, actionsOf(5, 4), StepOptions{})
	expectError(t, err, codes.FailedPrecondition, "5 batches", "of 5 batches", "HeldBatchesMax")
	held[2].Release()
	held[2].Release() // The second release does nothing.
	if held[2].Observations != nil {
		t.Error("a released batch can be read")
	}
	for step := 5; step < 20; step++ {
		if step == 10 {
			pool.Detach(ctx) // The next stream lists the held batches.
		}
		stepped(t, pool, actionsOf(step, 4), StepOptions{}).Release()
	}
	_, err = pool.Step(ctx, []int32{4, 4, 4, 4}, StepOptions{NextLevels: map[int32]int32{99: 1}})
	expectError(t, err, codes.InvalidArgument) // An error of the server ends the stream.
	stepped(t, pool, actionsOf(20, 4), StepOptions{}).Release()
	for i, batch := range held {
		if i != 2 && !bytes.Equal(batch.Observations, content[i]) {
			t.Error("held batch", i, "was overwritten")
		}
	}
}

func TestUnusedMemoryIsUnmapped(t *testing.T) {
	ctx := testContext(t)
	client := connected(t, Options{})
	before := mappings(t)
	pool, err := client.CreatePool(ctx, "", sharing(easy(4, "maze")), PoolOptions{})
	must(t, err)
	batch := stepped(t, pool, actionsOf(0, 4), StepOptions{})
	content := append([]byte(nil), batch.Observations...)
	must(t, pool.Delete(ctx))
	if !bytes.Equal(batch.Observations, content) || mappings(t) != before+1 {
		t.Error("a held batch became invalid with its pool")
	}
	batch.Release()
	if mappings(t) != before {
		t.Error("the memory stays mapped")
	}
	pool, err = client.CreatePool(ctx, "", sharing(easy(4, "maze")), PoolOptions{})
	must(t, err)
	stepped(t, pool, actionsOf(0, 4), StepOptions{}).Release()
	pool.Detach(ctx)
	if mappings(t) != before {
		t.Error("the memory is mapped after a detach")
	}
	stepped(t, pool, actionsOf(1, 4), StepOptions{}).Release()
	must(t, pool.Delete(ctx))
}

func TestAttachWithMoreBatchesMapsThemAll(t *testing.T) {
	ctx := testContext(t)
	client := connected(t, Options{})
	pool := madePool(t, client, sharing(easy(4, "maze")), PoolOptions{})
	held := stepped(t, pool, actionsOf(0, 4), StepOptions{})
	content := append([]byte(nil), held.Observations...)
	pool.Detach(ctx)
	more, err := client.GetPool(ctx, pool.Name(), PoolOptions{HeldBatchesMax: 9})
	must(t, err)
	stepped(t, more, actionsOf(1, 4), StepOptions{}).Release()
	more.Detach(ctx)
	for step := 0; step < 20; step++ {
		stepped(t, pool, actionsOf(step, 4), StepOptions{}).Release()
	}
	if pool.memory.message.BatchCount != 11 || len(held.Observations) != len(content) {
		t.Error(pool.memory.message.BatchCount)
	}
	held.Release()
}

func TestMismatchedMemoryIsRejected(t *testing.T) {
	pool := &pb.Pool{Spec: &pb.PoolSpec{EnvCount: 1}, ObservationShape: []int32{2}, ObservationBytes: 2}
	message := &pb.SharedMemory{Path: "/nowhere", SizeBytes: 4096, BatchCount: 1, BatchBytes: 4096}
	for field, kind := range sharedElements {
		offset := int64(64 * len(message.Arrays))
		shape := []int32{1}
		if kind == pb.ElementType_ELEMENT_TYPE_UINT8 {
			shape = []int32{1, 2}
		}
		message.Arrays = append(message.Arrays, &pb.SharedArray{
			Field: field, OffsetBytes: offset, ElementType: kind, Shape: shape,
		})
	}
	_, err := mapShared(message, pool, nil)
	expectError(t, err, codes.FailedPrecondition, "/nowhere", "TRANSPORT_STREAM")
	// Reading beyond the end of the file would raise SIGBUS.
	short := proto.Clone(message).(*pb.SharedMemory)
	short.Path = filepath.Join(t.TempDir(), "short")
	must(t, os.WriteFile(short.Path, make([]byte, 4095), 0600))
	_, err = mapShared(short, pool, nil)
	expectError(t, err, codes.FailedPrecondition, "it has 4095 bytes, expected: a regular file of 4096")
	short.Path = "/dev/zero"
	_, err = mapShared(short, pool, nil)
	expectError(t, err, codes.FailedPrecondition, "a regular file of 4096")
	for what, change := range map[string]func(*pb.SharedMemory){
		"too many batches":  func(m *pb.SharedMemory) { m.BatchCount = 2 },
		"no batch":          func(m *pb.SharedMemory) { m.BatchCount = 0 },
		"no arrays":         func(m *pb.SharedMemory) { m.Arrays = nil },
		"too few bytes":     func(m *pb.SharedMemory) { m.SizeBytes, m.BatchBytes = 64, 64 },
		"before its begin":  func(m *pb.SharedMemory) { m.Arrays[0].OffsetBytes = -64 },
		"beyond its end":    func(m *pb.SharedMemory) { m.Arrays[0].OffsetBytes = 4096 },
		"another type":      func(m *pb.SharedMemory) { m.Arrays[0].ElementType = pb.ElementType_ELEMENT_TYPE_UNSPECIFIED },
		"too many rows":     func(m *pb.SharedMemory) { m.Arrays[0].Shape[0] = 5000 },
		"rows too large":    func(m *pb.SharedMemory) { m.Arrays[0].Shape = []int32{1, 1 << 30, 1 << 30, 1 << 30} },
		"no shape":          func(m *pb.SharedMemory) { m.Arrays[0].Shape = nil },
		"an empty row":      func(m *pb.SharedMemory) { m.Arrays[0].Shape = []int32{1, 0} },
		"an array is twice": func(m *pb.SharedMemory) { m.Arrays[0].Field = m.Arrays[1].Field },
	} {
		t.Run(what, func(t *testing.T) {
			wrong := proto.Clone(message).(*pb.SharedMemory)
			change(wrong)
			_, err := mapShared(wrong, pool, nil)
			expectError(t, err, codes.Internal)
		})
	}
}
