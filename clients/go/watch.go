package procgenclient

import (
	"context"
	"io"

	"google.golang.org/grpc/codes"
)

// Calls `yield` with what a call tells again and again, each time anew and whole, until it gives false or the call ends. What
// is received while `yield` is busy is left out, but for the latest: there would be room for megabytes that are past. The
// caller ends the call.
func watch[Message any](ctx context.Context, receive func() (Message, error), yield func(Message) bool) error {
	latest := make(chan Message, 1)
	var end error
	go func() {
		defer close(latest)
		for {
			message, err := receive()
			if err != nil {
				end = err
				return
			}
			select {
			case <-latest: // Not seen, and past.
			default:
			}
			latest <- message
		}
	}()
	for message := range latest {
		if !yield(message) {
			return nil
		}
	}
	if end == io.EOF {
		return newError(codes.Unavailable, "the server ended its answers")
	}
	return fromRPC(ctx, end)
}
