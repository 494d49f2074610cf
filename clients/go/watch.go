package procgenclient

import (
	"context"
	"io"

	"google.golang.org/grpc/codes"
)

// Calls yield with the messages of a server stream until it returns false or the call ends.
// Messages that arrive while yield runs are conflated to the latest, so that none are buffered. The
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
			case <-latest: // Drops the one that yield has not seen.
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
		return newError(codes.Unavailable, "the server ended the stream")
	}
	return fromRPC(ctx, end)
}
