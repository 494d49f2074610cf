package procgenclient

import (
	"context"
	"io"

	"google.golang.org/grpc/codes"
)

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
