package procgenclient

// The client's requests and its parsing of responses match the wire fixtures
// (clients/wire_fixtures).

import (
	"bufio"
	"crypto/sha256"
	"encoding/hex"
	"encoding/json"
	"os"
	"os/exec"
	"path/filepath"
	"reflect"
	"strconv"
	"strings"
	"testing"

	pb "procgenclient/procgenv1"
)

type expectedPictures struct {
	Bytes  int
	SHA256 string
}

type expectedValues struct {
	Rewards           []float32
	First             []bool
	Terminated        []bool
	Truncated         []bool
	LevelSeeds        []int32          `json:"level_seeds"`
	PrevLevelSeeds    []int32          `json:"prev_level_seeds"`
	PrevLevelComplete []bool           `json:"prev_level_complete"`
	EpisodeReturns    []float32        `json:"episode_returns"`
	EpisodeLengths    []int32          `json:"episode_lengths"`
	FirstEnv          int              `json:"first_env"`
	Fingerprints      []string         `json:"fingerprints"`
	FinalObservations expectedPictures `json:"final_observations"`
	Observations      expectedPictures `json:"observations"`
}

func picturesOf(bytes []byte) expectedPictures {
	sum := sha256.Sum256(bytes)
	return expectedPictures{len(bytes), hex.EncodeToString(sum[:])}
}

func valuesOf(batch *Batch) *expectedValues {
	fingerprints := []string{}
	for _, hash := range batch.Fingerprints {
		fingerprints = append(fingerprints, strconv.FormatUint(hash, 10))
	}
	return &expectedValues{
		batch.Rewards, batch.First, batch.Terminated, batch.Truncated, batch.LevelSeeds, batch.PrevLevelSeeds,
		batch.PrevLevelComplete, batch.EpisodeReturns, batch.EpisodeLengths, batch.FirstEnv, fingerprints,
		picturesOf(batch.FinalObservations), picturesOf(batch.Observations),
	}
}

// The requests of the recorded session.
func playScript(t *testing.T, client *Client, encoding pb.Encoding) []*Batch {
	t.Helper()
	ctx := testContext(t)
	spec := easy(2, "maze")
	spec.Options.UseMonochromeAssets = true
	spec.ObservationFormat = &pb.ObservationFormat{Color: pb.Color_COLOR_GRAYSCALE, SizePx: 16}
	spec.Encoding = encoding
	pool, err := client.CreatePool(ctx, "", spec, PoolOptions{})
	must(t, err)
	batches := []*Batch{}
	keep := func(batch *Batch, err error) {
		t.Helper()
		must(t, err)
		batches = append(batches, batch)
	}
	keep(pool.Observe(ctx, Slice{}))
	keep(pool.Step(ctx, []int32{4, 7}, StepOptions{}))
	keep(pool.Step(ctx, []int32{-1, 3}, StepOptions{FinalObservations: true}))
	keep(pool.Step(ctx, []int32{8},
		StepOptions{FirstEnv: 1, RepeatCount: 3, NextLevels: map[int32]int32{1: 42}}))
	keep(pool.Step(ctx, []int32{4, 4}, StepOptions{Blind: true, Resets: []*pb.Reset{{Environment: 1}}}))
	levelSeed, randSeed := int32(7), int64(9)
	keep(pool.Reset(ctx, []*pb.Reset{{Environment: 0, LevelSeed: &levelSeed, RandSeed: &randSeed}}, Slice{}))
	sampler := &pb.LevelSampler{LevelSeeds: []int32{3, 5}, Weights: []float32{1, 2}, RandSeed: 1}
	keep(nil, pool.SetLevelSampler(ctx, sampler))
	keep(pool.Reset(ctx, nil, Slice{}))
	keep(pool.Step(ctx, []int32{2, 6}, StepOptions{}))
	must(t, pool.Delete(ctx))
	return batches
}

func TestWireFixturesReplay(t *testing.T) {
	folder := os.Getenv("PROCGEN_WIRE_FIXTURES")
	if folder == "" {
		t.Skip("set PROCGEN_WIRE_FIXTURES to clients/wire_fixtures")
	}
	text, err := os.ReadFile(filepath.Join(folder, "expected.json"))
	must(t, err)
	var expected []*expectedValues
	must(t, json.Unmarshal(text, &expected))
	for name, encoding := range map[string]pb.Encoding{
		"raw": pb.Encoding_ENCODING_RAW, "zstd": pb.Encoding_ENCODING_DELTA_ZSTD,
	} {
		t.Run(name, func(t *testing.T) {
			check := exec.Command(os.Getenv("PROCGEN_SYSTEM_PYTHON"), "-B", filepath.Join(folder, "check.py"), name)
			input, err := check.StdinPipe()
			must(t, err)
			output, err := check.StdoutPipe()
			must(t, err)
			must(t, check.Start())
			lines := bufio.NewScanner(output)
			lines.Scan()
			client, err := Connect(testContext(t), strings.TrimPrefix(lines.Text(), "listening on "), Options{})
			must(t, err)
			for i, batch := range playScript(t, client, encoding) {
				if batch != nil && !reflect.DeepEqual(valuesOf(batch), expected[i+1]) {
					t.Errorf("request %d: %+v, where %+v is expected", i+1, valuesOf(batch), expected[i+1])
				}
			}
			must(t, client.Close())
			must(t, input.Close())
			for lines.Scan() {
				t.Log(lines.Text())
			}
			must(t, check.Wait())
		})
	}
}
