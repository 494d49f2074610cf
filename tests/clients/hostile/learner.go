// A learner of the Go client; hostile_test.py describes its output.
package main

import (
	"bytes"
	"context"
	"encoding/binary"
	"encoding/json"
	"errors"
	"fmt"
	"hash/crc32"
	"os"
	"strings"
	"time"

	client "procgenclient"
	pb "procgenclient/procgenv1"
)

const envCount = 5

func digestOf(before uint32, batch *client.Batch) uint32 {
	for _, values := range []interface{}{batch.Observations, batch.Rewards, batch.Fingerprints, batch.FinalObservations} {
		var written bytes.Buffer
		_ = binary.Write(&written, binary.LittleEndian, values)
		before = crc32.Update(before, crc32.IEEETable, written.Bytes())
	}
	return before
}

func learn(address, encoding string) (uint32, error) {
	ctx, cancel := context.WithTimeout(context.Background(), 15*time.Second)
	defer cancel()
	connection, err := client.Connect(ctx, address, client.Options{ReconnectTimeout: time.Second})
	if err != nil {
		return 0, err
	}
	defer connection.Close()
	seed := int64(5)
	spec := &pb.PoolSpec{
		Games:    []string{"coinrun"},
		EnvCount: envCount,
		Options:  &pb.EnvironmentOptions{DistributionMode: pb.DistributionMode_DISTRIBUTION_MODE_EASY, RandSeed: &seed},
	}
	if encoding != "raw" {
		spec.Encoding = pb.Encoding_ENCODING_DELTA_ZSTD
	}
	pool, err := connection.CreatePool(ctx, "", spec, client.PoolOptions{})
	if err != nil {
		return 0, err
	}
	batch, err := pool.Observe(ctx, client.Slice{})
	if err != nil {
		return 0, err
	}
	digest := digestOf(0, batch)
	for step := int32(0); step < 10; step++ {
		actions := make([]int32, envCount)
		for i := range actions {
			actions[i] = (step*31+int32(i)*17)%16 - 1
		}
		if batch, err = pool.Step(ctx, actions, client.StepOptions{FinalObservations: true}); err != nil {
			return 0, err
		}
		digest = digestOf(digest, batch)
	}
	pool.Detach(ctx)
	return lookOn(ctx, connection, pool, digest)
}

// Unary calls.
func lookOn(ctx context.Context, connection *client.Client, pool *client.Pool, digest uint32) (uint32, error) {
	states, err := pool.SaveStates(ctx, 2, 0)
	if err != nil {
		return 0, err
	}
	for _, state := range states {
		size := make([]byte, 4)
		binary.LittleEndian.PutUint32(size, uint32(len(state.Snapshot)))
		digest = crc32.Update(digest, crc32.IEEETable, size)
	}
	frames, err := pool.Render(ctx, 64, 1, 3)
	if err != nil {
		return 0, err
	}
	for _, frame := range frames {
		digest = crc32.Update(digest, crc32.IEEETable, frame.Image)
	}
	if _, err = pool.GetEpisode(ctx, 0, pb.EpisodeSelector_EPISODE_SELECTOR_CURRENT); err != nil {
		return 0, err
	}
	if _, err = connection.ListPools(ctx); err != nil {
		return 0, err
	}
	return digest, pool.Delete(ctx)
}

func main() {
	for _, argument := range os.Args[1:] {
		words := strings.Split(argument, "=")
		fmt.Println("begin", words[0])
		report := map[string]interface{}{"mode": words[0]}
		digest, err := learn(words[2], words[1])
		var own *client.Error
		if errors.As(err, &own) {
			report["error"], report["message"] = own.Code.String(), own.Message
		} else if err != nil {
			panic(err)
		} else {
			report["digest"] = digest
		}
		line, _ := json.Marshal(report)
		fmt.Println(string(line))
	}
}
