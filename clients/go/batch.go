package procgenclient

// Batch is how n environments stand after a request. Row i is environment FirstEnv + i of the pool. F is the bytes
// of one observation, m the number of rows whose episode ended in this step.
//
// Observations and FinalObservations are slices of the received message, which nobody writes again. Where an answer came in
// several responses they are joined, and what came encoded is decoded.
//
// Of a pool that shares memory they are the server's memory itself, valid until Release; after that the server draws into
// them again, or they are no memory at all.
type Batch struct {
	SequenceNumber   int64   // Number of the request that this answers.
	FirstEnv         int     // Index in the pool of row 0.
	ObservationShape []int32 // Shape of one observation, e.g. [64, 64, 3].

	Rewards           []float32 // Of this step, the old episode's where one ended   [n]
	First             []bool    // A new episode has begun                           [n]
	Terminated        []bool    // The game (or action -1) ended the episode         [n]
	Truncated         []bool    // The time limit ended the episode                  [n]
	LevelSeeds        []int32   // Level in the observation                          [n]
	PrevLevelSeeds    []int32   // Level that was stepped                            [n]
	PrevLevelComplete []bool    // That level was completed by this step             [n]
	EpisodeReturns    []float32 // Of the ended or running episode                   [n]
	EpisodeLengths    []int32   // Of the same, in steps                             [n]
	Fingerprints      []uint64  // Hashes of episodes that ended, in order           [m]
	FinalObservations []byte    // Last ones of those, if asked for                  [m * F]
	Observations      []byte    // What the agents see; empty without pictures       [n * F]

	held *heldBatch // nil: the values came in responses, or it was released.
}

// Release gives a batch of shared memory back; its Observations and FinalObservations are nil then. Other batches need no
// release. Any goroutine, one at a time.
func (b *Batch) Release() {
	if b.held == nil {
		return
	}
	b.Observations, b.FinalObservations = nil, nil
	b.held.release()
	b.held = nil
}

// EnvCount is the number of rows, n.
func (b *Batch) EnvCount() int { return len(b.Rewards) }

// Observation is that of a row.
func (b *Batch) Observation(row int) []byte {
	size := elements(b.ObservationShape)
	return b.Observations[row*size : (row+1)*size]
}

// One response with values: the answer to a request, or a part of it.
type part struct {
	Batch
	count  int
	last   bool
	shared *sharedPart // nil: the values are in the response.
}

// Where the values are in shared memory.
type sharedPart struct {
	number               int32
	observations, finals bool // Were written.
}

func elements(shape []int32) int {
	product := 1
	for _, side := range shape {
		product *= int(side)
	}
	return product
}

// Joins the responses to one request, which were checked as they came.
func assemble(parts []*part, shape []int32) *Batch {
	whole := &parts[0].Batch
	whole.ObservationShape = shape
	for _, next := range parts[1:] {
		whole.append(&next.Batch)
	}
	return whole
}

func (b *Batch) append(next *Batch) {
	b.Rewards = append(b.Rewards, next.Rewards...)
	b.First = append(b.First, next.First...)
	b.Terminated = append(b.Terminated, next.Terminated...)
	b.Truncated = append(b.Truncated, next.Truncated...)
	b.LevelSeeds = append(b.LevelSeeds, next.LevelSeeds...)
	b.PrevLevelSeeds = append(b.PrevLevelSeeds, next.PrevLevelSeeds...)
	b.PrevLevelComplete = append(b.PrevLevelComplete, next.PrevLevelComplete...)
	b.EpisodeReturns = append(b.EpisodeReturns, next.EpisodeReturns...)
	b.EpisodeLengths = append(b.EpisodeLengths, next.EpisodeLengths...)
	b.Fingerprints = append(b.Fingerprints, next.Fingerprints...)
	b.FinalObservations = append(b.FinalObservations, next.FinalObservations...)
	b.Observations = append(b.Observations, next.Observations...)
}
