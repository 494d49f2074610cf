package procgenclient

import (
	"context"
	"io"

	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

// What a server sends to who watches a pool, at most. In bytes.
const watchBytes = 16 << 20

// How many environments are watched where nobody tells which.
const watchedDefault = 16

// WatchOptions is what is watched, and how; the zero value will do.
type WatchOptions struct {
	// Environments in the order wanted, at most 64. Empty: the first 16.
	Environments []int32
	// Side of the square frames in pixels, in [16, 2048]; 64: what the agent sees, pixel by pixel. 0: 256.
	SidePx int32
	// Moments in a second at most, above 0 and at most 60. 0: 15.
	FramesPerSecondMax float32
}

// Watch shows environments while somebody steps them, and never slows who does: it calls `see` with frames (RGB, top row
// first) of how they are now, and then of how they are after something has changed, at a bounded rate. What changes while
// `see` is busy is left out, but for the newest. It ends with nil when `see` gives false, with ABORTED when the pool is gone,
// and with UNAVAILABLE when the server stops or the connection breaks.
func (p *Pool) Watch(ctx context.Context, options WatchOptions, see func(*pb.WatchPoolResponse) bool) error {
	request := &pb.WatchPoolRequest{
		Pool:               p.Name(),
		Environments:       options.Environments,
		SidePx:             options.SidePx,
		Format:             pb.FrameFormat_FRAME_FORMAT_RGB,
		FramesPerSecondMax: options.FramesPerSecondMax,
		ResponseBytesMax:   watchBytes,
	}
	if len(request.Environments) == 0 {
		request.Environments = firstEnvironments(clamp(p.EnvCount(), 1, watchedDefault))
	}
	callContext, cancel := context.WithCancel(p.client.with(ctx))
	defer cancel()
	call, err := p.client.renders.WatchPool(callContext, request)
	if err != nil {
		return fromRPC(ctx, err)
	}
	return watch(ctx, call.Recv, see)
}

// Calls `see` with what a call tells again and again, each time anew and whole, until it gives false or the call ends. What
// is received while `see` is busy is left out, but for the newest: there would be room for megabytes that are past. The
// caller ends the call.
func watch[Message any](ctx context.Context, receive func() (Message, error), see func(Message) bool) error {
	newest := make(chan Message, 1)
	var end error
	go func() {
		defer close(newest)
		for {
			message, err := receive()
			if err != nil {
				end = err
				return
			}
			select {
			case <-newest: // Not seen, and past.
			default:
			}
			newest <- message
		}
	}()
	for message := range newest {
		if !see(message) {
			return nil
		}
	}
	if end == io.EOF {
		return newError(codes.Unavailable, "the server ended its answers")
	}
	return fromRPC(ctx, end)
}
