// A random agent: random_agent ADDRESS STEPS
package main

import (
	"context"
	"fmt"
	"log"
	"math/rand"
	"os"
	"strconv"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/credentials/insecure"
	"google.golang.org/grpc/status"

	pb "procgen/v1"
)

const (
	envCount    = 4
	roundSteps  = 100 // Steps between two checkpoints.
	actionCount = 15
)

type service = pb.PoolServiceClient

var newClient = pb.NewPoolServiceClient

// A checkpoint is what a run needs to continue on a new stream.
type checkpoint struct {
	states  []*pb.State
	step    int
	returns []float32 // Of the episodes that have ended.
}

// call sends a request and waits for its response.
func call(stream grpc.BidiStreamingClient[pb.RunPoolRequest, pb.RunPoolResponse],
	request *pb.RunPoolRequest) (*pb.RunPoolResponse, error) {
	_ = stream.Send(request) // Recv returns the error of a stream that has ended.
	return stream.Recv()
}

// run steps a pool from a checkpoint, and updates it after each round. The pool lives as long as
// the stream.
func run(client service, steps int, saved *checkpoint) error {
	ctx, cancel := context.WithCancel(context.Background())
	defer cancel()
	stream, err := client.RunPool(ctx)
	if err != nil {
		return err
	}
	spec := &pb.PoolSpec{Games: []string{"coinrun"}, EnvCount: envCount}
	_, err = call(stream, &pb.RunPoolRequest{Request: &pb.RunPoolRequest_Start{
		Start: &pb.StartPool{Spec: spec, States: saved.states}}})
	for err == nil && saved.step < steps {
		returns := saved.returns
		for range roundSteps {
			step := &pb.Step{Slice: &pb.Slice{EnvCount: envCount}, Actions: make([]int32, envCount)}
			for i := range step.Actions {
				step.Actions[i] = rand.Int31n(actionCount)
			}
			response, err := call(stream, &pb.RunPoolRequest{Request: &pb.RunPoolRequest_Step{Step: step}})
			if err != nil {
				return err
			}
			batch := response.GetBatch() // Observations: uint8 [4, 64, 64, 3]
			for i, value := range batch.EpisodeReturns {
				if batch.Terminated[i] || batch.Truncated[i] {
					returns = append(returns, value)
				}
			}
		}
		var response *pb.RunPoolResponse
		response, err = call(stream, &pb.RunPoolRequest{Request: &pb.RunPoolRequest_SaveStates{
			SaveStates: &pb.SaveEnvironments{}}})
		if err == nil {
			*saved = checkpoint{response.GetStates().States, saved.step + roundSteps, returns}
		}
	}
	return err
}

func main() {
	steps, err := strconv.Atoi(os.Args[2])
	if err != nil {
		log.Fatal(err)
	}
	connection, err := grpc.NewClient(os.Args[1],
		grpc.WithTransportCredentials(insecure.NewCredentials()))
	if err != nil {
		log.Fatal(err)
	}
	var saved checkpoint
	err = run(newClient(connection), steps, &saved)
	for try := 0; status.Code(err) == codes.Unavailable && try < 30; try++ {
		time.Sleep(time.Second)
		fmt.Printf("continuing after %d steps: %v\n", saved.step, err)
		err = run(newClient(connection), steps, &saved)
	}
	if err != nil {
		log.Fatal(err)
	}
	sum := float32(0)
	for _, value := range saved.returns {
		sum += value
	}
	fmt.Printf("%d episodes, mean return %.3f\n", len(saved.returns), sum/float32(len(saved.returns)))
}
