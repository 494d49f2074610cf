// A random agent: go run procgenclient/examples/random_agent -server localhost:50051
package main

import (
	"context"
	"flag"
	"fmt"
	"log"
	"math/rand"

	"procgenclient"
	pb "procgenclient/procgenv1"
)

func main() {
	server := flag.String("server", "localhost:50051", "where the server listens")
	game := flag.String("game", "coinrun", "what is played")
	flag.Parse()
	ctx := context.Background()
	client, err := procgenclient.Connect(ctx, *server, procgenclient.Options{})
	check(err)
	spec := &pb.PoolSpec{Games: []string{*game}, EnvCount: 64}
	pool, err := client.CreatePool(ctx, "", spec, procgenclient.HoldOptions{})
	check(err)
	episodes := 0
	actions := make([]int32, 64)
	for step := 0; step < 1000; step++ {
		for i := range actions {
			actions[i] = rand.Int31n(15)
		}
		batch, err := pool.Step(ctx, actions, procgenclient.StepOptions{})
		check(err)
		episodes += len(batch.Fingerprints) // One for each episode that ended.
	}
	fmt.Printf("%d episodes of %s\n", episodes, *game)
	check(pool.Delete(ctx))
}

func check(err error) {
	if err != nil {
		log.Fatal(err)
	}
}
