package procgenclient

import (
	"context"
	"fmt"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"
)

// Error is an error of the server or of this client: gRPC's status code and a message that contains
// the value given and the values allowed. The client validates requests before sending, because an
// error of the server would end the stream. status.Code(err) returns the code. errors.Is reports
// context.Canceled or context.DeadlineExceeded for a call that its context ended.
type Error struct {
	Code    codes.Code
	Message string
	cause   error
}

func (e *Error) Error() string { return fmt.Sprintf("%v: %s", e.Code, e.Message) }

// Unwrap returns the context's error, if that ended the call.
func (e *Error) Unwrap() error { return e.cause }

// GRPCStatus returns the status for status.Code and status.FromError.
func (e *Error) GRPCStatus() *status.Status { return status.New(e.Code, e.Message) }

func newError(code codes.Code, format string, arguments ...interface{}) *Error {
	return &Error{Code: code, Message: fmt.Sprintf(format, arguments...)}
}

func invalid(format string, arguments ...interface{}) *Error {
	return newError(codes.InvalidArgument, format, arguments...)
}

// Converts an error of gRPC, of a call under ctx, to an Error.
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
	return &Error{Code: of.Code(), Message: "cancelled: " + ctx.Err().Error(), cause: ctx.Err()}
}
