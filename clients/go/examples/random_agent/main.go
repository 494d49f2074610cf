// A random agent: go run procgenclient/examples/random_agent localhost:50051 coinrun
package main

import (
	"context"
	"fmt"
	"os"

	"procgenclient"
)

func main() {
	playing := procgenclient.Play(context.Background(), os.Args[1], os.Args[2], 64)
	episodes := 0
	for step := 0; step < 1000 && playing.Step(playing.SampleActions()); step++ {
		episodes += len(playing.Batch.Fingerprints) // One for each episode that ended.
	}
	fmt.Println(episodes, "episodes of", os.Args[2], playing.Close())
}
