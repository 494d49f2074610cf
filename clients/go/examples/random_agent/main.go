// A random agent: go run procgenclient/examples/random_agent -server localhost:50051 -game coinrun
package main

import (
	"context"
	"flag"
	"fmt"
	"log"

	"procgenclient"
)

func main() {
	server := flag.String("server", "localhost:50051", "address of the server")
	game := flag.String("game", "coinrun", "name of the game")
	flag.Parse()
	env := procgenclient.NewVectorEnv(context.Background(), *server, *game, 64)
	episodes := 0
	for step := 0; step < 1000 && env.Step(env.SampleActions()); step++ {
		episodes += len(env.Batch.Fingerprints) // One for each episode that ended.
	}
	if err := env.Close(); err != nil {
		log.Fatal(err)
	}
	fmt.Println(episodes, "episodes of", *game)
}
