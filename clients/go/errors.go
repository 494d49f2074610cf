package procgenclient

import (
	"context"
	"fmt"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"
)

// Error is what goes wrong between this client and a server: the status code of gRPC and the server's own message, which
// says what was given and what is allowed. What the client can tell by itself is the same type, without asking the server,
// so that a mistake does not cost the stream. status.Code(err) gives its code; a call that its context ended is, by
// errors.Is, also context.Canceled or context.DeadlineExceeded.
type Error struct {
	Code    codes.Code
	Message string
	cause   error
}

func (e *Error) Error() string { return fmt.Sprintf("%v: %s", e.Code, e.Message) }

// Unwrap gives the context's error, if that ended the call.
func (e *Error) Unwrap() error { return e.cause }

// GRPCStatus lets status.Code and status.FromError see the code.
func (e *Error) GRPCStatus() *status.Status { return status.New(e.Code, e.Message) }

func newError(code codes.Code, format string, arguments ...interface{}) *Error {
	return &Error{Code: code, Message: fmt.Sprintf(format, arguments...)}
}

func invalid(format string, arguments ...interface{}) *Error {
	return newError(codes.InvalidArgument, format, arguments...)
}

// The Error for one of gRPC's, of a call under ctx.
func fromRPC(ctx context.Context, err error) error {
	if err == nil {
		return nil
	}
	if ctx.Err() != nil {
		return fromContext(ctx)
	}
	of, _ := status.FromError(err)
	return &Error{Code: of.Code(), Message: of.Message()}
}

func fromContext(ctx context.Context) *Error {
	of := status.FromContextError(ctx.Err())
	return &Error{Code: of.Code(), Message: "given up: " + ctx.Err().Error(), cause: ctx.Err()}
}
