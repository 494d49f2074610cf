package procgenclient

// Batch is the answer to a request: the values of n environments. Row i is environment FirstEnv + i
// of the pool. F is the bytes of one observation, m the number of rows whose episode ended in this
// step.
//
// Observations and FinalObservations are slices of the received message, which is not reused.
// Several responses are joined, and encoded observations decoded, into new slices.
//
// With shared memory they are slices of the server's memory, valid until Release. After that the
// server overwrites the memory, or it is unmapped.
type Batch struct {
	SequenceNumber   int64   // Number of the request that this answers.
	FirstEnv         int     // Index in the pool of row 0.
	ObservationShape []int32 // Shape of one observation, e.g. [64, 64, 3].

	Rewards           []float32 // Reward of this step, of the old episode if one ended   [n]
	First             []bool    // A new episode has started                              [n]
	Terminated        []bool    // The game (or action -1) ended the episode              [n]
	Truncated         []bool    // The time limit ended the episode                       [n]
	LevelSeeds        []int32   // Seed of the level in the observation                   [n]
	PrevLevelSeeds    []int32   // Seed of the level that was stepped                     [n]
	PrevLevelComplete []bool    // This step completed that level                         [n]
	EpisodeReturns    []float32 // Return of the ended or current episode                 [n]
	EpisodeLengths    []int32   // Length of the same episode, in steps                   [n]
	Fingerprints      []uint64  // Hashes of the ended episodes, in order                 [m]
	FinalObservations []byte    // Last observations of the ended episodes, if requested  [m * F]
	Observations      []byte    // Observations; empty with Blind                         [n * F]

	held *heldBatch // nil without shared memory, and after Release.
}

// Release releases a batch of shared memory: the server may overwrite it, and Observations and
// FinalObservations become nil. It does nothing for other batches. It may be called from any
// goroutine, one at a time.
func (b *Batch) Release() {
	if b.held == nil {
		return
	}
	b.Observations, b.FinalObservations = nil, nil
	b.held.release()
	b.held = nil
}

// EnvCount returns the number of rows, n.
func (b *Batch) EnvCount() int { return len(b.Rewards) }

// Observation returns the observation of a row, [F], without a copy.
func (b *Batch) Observation(row int) []byte {
	size := elements(b.ObservationShape)
	return b.Observations[row*size : (row+1)*size]
}

// One response with values: the answer to a request, or a part of it.
type part struct {
	Batch
	count  int
	last   bool
	shared *sharedPart // nil without shared memory.
}

// The batch of shared memory that contains the values.
type sharedPart struct {
	number               int32
	observations, finals bool // Whether they were written.
}

func elements(shape []int32) int {
	product := 1
	for _, side := range shape {
		product *= int(side)
	}
	return product
}

// Joins the validated responses to one request.
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
