package procgenclient

import (
	"context"
	"fmt"
	"io"
	"math/rand"
	"strings"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "procgenclient/procgenv1"
)

// Trailing metadata of a server that drains, which must not be retried.
const drainsKey = "procgen-drains"

// Maximum number of responses of unknown kinds that are skipped before an answer.
const noticesMax = 1000

var stepPoolDescription = &grpc.StreamDesc{StreamName: "StepPool", ServerStreams: true, ClientStreams: true}

const stepPoolMethod = "/procgen.v1.StepService/StepPool"

// The call ended because its connection broke; a retry may succeed.
type brokenConnection struct{ error }

// A StepPool stream that is resumed after broken connections. It sends requests and receives their
// answers, in order. After a broken connection it attaches again and resends unanswered requests,
// for at most the client's ReconnectTimeout. The server keeps its answers meanwhile, so no step is
// lost or executed twice. Any other error ends the stream.
type stream struct {
	client     *Client
	attach     *pb.Attach
	known      *pb.Pool // The pool as known before attaching.
	attached   *pb.Attached
	decoder    *ObservationDecoder
	memory     *sharedMemory // nil without shared memory.
	unanswered []*pb.StepPoolRequest
	next       int64 // Number of the next request.

	call   grpc.ClientStream
	cancel context.CancelFunc // Ends the call.
}

// Attaches a stream. `memory` is the mapping of the pool's earlier streams, or nil.
func openStream(ctx context.Context, client *Client, attach *pb.Attach, known *pb.Pool, memory *sharedMemory) (*stream, error) {
	s := &stream{client: client, attach: attach, known: known, memory: memory}
	s.attach.Resumable = client.reconnectTimeout > 0
	var err error
	if s.attached, err = s.open(ctx, false); err != nil {
		if broken, is := err.(brokenConnection); is {
			err = broken.error
		}
		return nil, err
	}
	if s.decoder, err = decoderFor(s.attached.Pool); err != nil {
		s.drop()
		return nil, err
	}
	s.next = s.attached.NextSequenceNumber
	// After a broken connection the attached stream is this one, which the server may not have
	// noticed.
	s.attach.TakeOver = true
	return s, nil
}

// Sends a request with the next sequence number.
func (s *stream) send(request *pb.StepPoolRequest) {
	request.SequenceNumber = s.next
	s.next++
	s.unanswered = append(s.unanswered, request)
	s.put(request)
}

func (s *stream) put(request *pb.StepPoolRequest) {
	if s.memory != nil {
		// Lets the server free batches of answers that have arrived.
		request.AcknowledgedSequenceNumber = s.unanswered[0].SequenceNumber - 1
		request.ReleasedBatches = s.memory.takeReleased()
	}
	// An error is reported by the next receive.
	_ = s.call.SendMsg(request)
}

// Waits for the answer to the oldest unanswered request. Returns its parts, none for an answer
// without values. An error ends the stream.
func (s *stream) receive(ctx context.Context) ([]*part, error) {
	for {
		parts, err := s.readAnswer(ctx)
		if broken, is := err.(brokenConnection); is {
			if err = s.resume(ctx, broken.error); err == nil {
				continue
			}
		}
		if err == nil {
			err = s.decode(parts)
		}
		if err == nil {
			err = s.hold(parts)
		}
		if err != nil {
			s.drop()
			return nil, err
		}
		s.unanswered = s.unanswered[1:]
		return parts, nil
	}
}

// Ends the stream. Unanswered requests are executed, and their answers lost.
func (s *stream) close(ctx context.Context) {
	_ = s.call.CloseSend()
	defer cancelWith(ctx, s.cancel)()
	for s.call.RecvMsg(&response{}) == nil { // Until the server has ended the stream.
	}
	s.drop()
}

// Ends the stream at once.
func (s *stream) drop() {
	s.cancel()
}

func (s *stream) readAnswer(ctx context.Context) ([]*part, error) {
	var parts []*part
	expected := s.expected(s.unanswered[0])
	for notices := 0; notices <= noticesMax; {
		got, err := s.nextResponse(ctx)
		if err != nil {
			return nil, err
		}
		number := got.message.GetSequenceNumber()
		if got.part != nil {
			number = got.part.SequenceNumber
		} else if got.message.Response == nil && number == 0 {
			notices++
			continue // A kind that only newer clients know, and that answers no request: ignored.
		}
		if next := s.unanswered[0].SequenceNumber; number != next {
			return nil, newError(codes.Internal, "%s answered request %d, expected: %d", s.attach.Pool, number, next)
		}
		if got.part == nil {
			if got.message.GetAck() == nil || !expected.ack {
				return nil, wrong("request %d: %T, expected: its values", number, got.message.Response)
			}
			return parts, nil
		}
		if err := expected.check(got.part, parts); err != nil {
			return nil, err
		}
		if parts = append(parts, got.part); got.part.last {
			return parts, nil
		}
	}
	return nil, wrong("more than %d responses of unknown kinds, expected: an answer", noticesMax)
}

// Decodes a complete answer. An incomplete one is not decoded, because it is sent again after a
// broken connection.
func (s *stream) decode(parts []*part) error {
	for _, part := range parts {
		if s.decoder == nil || len(part.Observations) == 0 {
			continue
		}
		decoded, err := s.decoder.Decode(part.FirstEnv, part.count, part.Observations)
		if err != nil {
			return newError(codes.DataLoss, "the answer of %s to request %d: %v", s.attach.Pool, part.SequenceNumber, err)
		}
		part.Observations = decoded
	}
	return nil
}

func (s *stream) hold(parts []*part) error {
	for _, part := range parts {
		if part.shared == nil {
			continue
		}
		if err := s.memory.hold(part); err != nil {
			return err
		}
	}
	return nil
}

func (s *stream) nextResponse(ctx context.Context) (*response, error) {
	if ctx.Err() != nil {
		return nil, fromContext(ctx)
	}
	stop := cancelWith(ctx, s.cancel)
	got := &response{}
	err := s.call.RecvMsg(got)
	if stop() {
		return nil, fromContext(ctx)
	}
	if err == nil {
		return got, nil
	}
	why := fromRPC(ctx, err)
	if err == io.EOF { // The server took the end of the connection for a half-close.
		why = newError(codes.Unavailable, "the server ended the stream of %s", s.attach.Pool)
	}
	if s.client.reconnectTimeout > 0 && (err == io.EOF || isBrokenConnection(err, s.call)) {
		return nil, brokenConnection{why}
	}
	return nil, why
}

func (s *stream) open(ctx context.Context, waitForReady bool) (*pb.Attached, error) {
	// A new context, because the call outlives ctx.
	callContext, cancel := context.WithCancel(s.client.with(context.Background()))
	s.cancel = cancel
	stop := cancelWith(ctx, cancel)
	call, err := s.client.connection.NewStream(callContext, stepPoolDescription, stepPoolMethod,
		grpc.WaitForReady(waitForReady))
	cancelled := stop()
	if err != nil || cancelled {
		cancel()
		if cancelled {
			return nil, fromContext(ctx)
		}
		if s.client.reconnectTimeout > 0 && status.Code(err) == codes.Unavailable {
			return nil, brokenConnection{fromRPC(ctx, err)}
		}
		return nil, fromRPC(ctx, err)
	}
	s.call = call
	if s.memory != nil {
		s.attach.HeldBatches = s.memory.takeHeld()
	}
	_ = call.SendMsg(&pb.StepPoolRequest{Request: &pb.StepPoolRequest_Attach{Attach: s.attach}})
	got, err := s.nextResponse(ctx)
	if err == nil && got.message.GetAttached() == nil {
		err = newError(codes.Internal, "the first response of %s does not answer attach", s.attach.Pool)
	}
	if err == nil {
		err = checkAttached(got.message.GetAttached(), s.attach, s.known)
	}
	if err == nil && got.message.GetAttached().SharedMemory != nil {
		s.memory, err = mapShared(got.message.GetAttached().SharedMemory, s.known, s.memory)
	}
	if err != nil {
		cancel()
		return nil, err
	}
	return got.message.GetAttached(), nil
}

// Resumes with a new connection, or returns the error that prevents it.
func (s *stream) resume(ctx context.Context, why error) error {
	deadline := time.Now().Add(s.client.reconnectTimeout)
	for backoff := backoffMin; ; backoff = minDuration(2*backoff, backoffMax) {
		s.drop()
		delay := time.Duration(float64(backoff) * (0.5 + rand.Float64()))
		if time.Now().Add(delay).After(deadline) {
			return newError(codes.Unavailable, "the connection broke and could not be made again within %v: %v",
				s.client.reconnectTimeout, why)
		}
		select {
		case <-time.After(delay):
		case <-ctx.Done():
			return fromContext(ctx)
		}
		attached, err := s.openBy(ctx, deadline)
		if broken, is := err.(brokenConnection); is {
			why = broken.error
			continue
		}
		if err == nil {
			err = s.checkNextNumber(attached)
		}
		if err != nil {
			return err
		}
		for _, request := range s.unanswered {
			s.put(request)
		}
		return nil
	}
}

func (s *stream) openBy(ctx context.Context, deadline time.Time) (*pb.Attached, error) {
	limited, cancel := context.WithDeadline(ctx, deadline)
	defer cancel()
	attached, err := s.open(limited, true)
	if err != nil && ctx.Err() == nil && limited.Err() != nil {
		return nil, brokenConnection{err}
	}
	return attached, err
}

// Checks that no other client has stepped the pool.
func (s *stream) checkNextNumber(attached *pb.Attached) error {
	least := s.unanswered[0].SequenceNumber
	if at := attached.NextSequenceNumber; at < least || at > s.next {
		return newError(codes.Aborted, "%s is at request %d, and this stream left it between %d and %d: another client "+
			"has stepped it, or it is another pool of the same name", s.attach.Pool, at, least, s.next)
	}
	return nil
}

func isBrokenConnection(err error, call grpc.ClientStream) bool {
	switch status.Code(err) {
	case codes.Unavailable:
		return len(call.Trailer().Get(drainsKey)) == 0
	case codes.Unknown:
		return true
	case codes.Internal:
		// gRPC's texts after a connection was reset or closed within a stream.
		text := fmt.Sprint(err)
		return strings.Contains(text, "RST_STREAM") || strings.Contains(text, "EOF") || strings.Contains(text, "transport")
	}
	return false
}

// Calls cancel if ctx ends before the returned function is called. That function returns whether
// cancel was called.
func cancelWith(ctx context.Context, cancel func()) (stop func() (cancelled bool)) {
	if ctx.Done() == nil {
		return func() bool { return false }
	}
	done := make(chan struct{})
	cancelled := make(chan bool)
	go func() {
		select {
		case <-ctx.Done():
			cancel()
			cancelled <- true
		case <-done:
			cancelled <- false
		}
	}()
	return func() bool {
		close(done)
		return <-cancelled
	}
}

func minDuration(a, b time.Duration) time.Duration {
	if a < b {
		return a
	}
	return b
}
