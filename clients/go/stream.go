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

// A server that drains says so in its trailers, and that it is not to be asked again.
const drainsKey = "procgen-drains"

// So many responses of kinds that are not known are ignored before an answer.
const noticesMax = 1000

var stepPoolDescription = &grpc.StreamDesc{StreamName: "StepPool", ServerStreams: true, ClientStreams: true}

const stepPoolMethod = "/procgen.v1.StepService/StepPool"

// The call ended because its connection broke, not by an answer of the server.
type brokenConnection struct{ error }

// One learner's hold of one pool. It sends requests and receives their answers, in order. Where the connection breaks it
// attaches again and sends again what is unanswered, until the client's ReconnectTimeout: the server keeps its answers
// meanwhile, so no step is lost or taken twice. After any other error the stream is over.
type stream struct {
	client     *Client
	attach     *pb.Attach
	known      *pb.Pool // The pool as it was before.
	attached   *pb.Attached
	decoder    *ObservationDecoder
	memory     *sharedMemory // nil: values come in responses.
	unanswered []*pb.StepPoolRequest
	next       int64 // Number of the next request.

	call   grpc.ClientStream
	cancel context.CancelFunc // Ends the call.
}

// `memory` is what the pool's earlier streams have mapped, or nil.
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
	// Whoever has it when the connection breaks was this stream, as far as the server knows.
	s.attach.TakeOver = true
	return s, nil
}

// Numbers a request and sends it.
func (s *stream) send(request *pb.StepPoolRequest) {
	request.SequenceNumber = s.next
	s.next++
	s.unanswered = append(s.unanswered, request)
	s.put(request)
}

func (s *stream) put(request *pb.StepPoolRequest) {
	if s.memory != nil {
		// So that the batches of answers that have arrived are not kept for repetition.
		request.AcknowledgedSequenceNumber = s.unanswered[0].SequenceNumber - 1
		request.ReleasedBatches = s.memory.takeReleased()
	}
	// What goes wrong here is told when its answer is waited for.
	_ = s.call.SendMsg(request)
}

// Waits for the answer to the oldest unanswered request: one part or more, or none if there is nothing to tell. After an
// error the stream is over.
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

// Ends the stream; requests in flight are carried out, and their answers lost.
func (s *stream) close(ctx context.Context) {
	_ = s.call.CloseSend()
	defer giveUpWith(ctx, s.cancel)()
	for s.call.RecvMsg(&response{}) == nil { // Until the server says that the stream has ended.
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
			continue // Of a later server's kinds and no answer: clients ignore those.
		}
		if next := s.unanswered[0].SequenceNumber; number != next {
			return nil, newError(codes.Internal, "%s answered request %d, where %d is next", s.attach.Pool, number, next)
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
	return nil, wrong("more than %d responses of unknown kinds, expected: that to a request", noticesMax)
}

// Decodes a whole answer: what was read of one whose connection broke comes again.
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
	stop := giveUpWith(ctx, s.cancel)
	got := &response{}
	err := s.call.RecvMsg(got)
	if stop() {
		return nil, fromContext(ctx)
	}
	if err == nil {
		return got, nil
	}
	why := fromRPC(ctx, err)
	if err == io.EOF { // The server took the connection's end for that of the stream.
		why = newError(codes.Unavailable, "the server ended the stream of %s", s.attach.Pool)
	}
	if s.client.reconnectTimeout > 0 && (err == io.EOF || isBrokenConnection(err, s.call)) {
		return nil, brokenConnection{why}
	}
	return nil, why
}

func (s *stream) open(ctx context.Context, waitForReady bool) (*pb.Attached, error) {
	// Of its own: the call outlives the context of whoever attaches.
	callContext, cancel := context.WithCancel(s.client.with(context.Background()))
	s.cancel = cancel
	stop := giveUpWith(ctx, cancel)
	call, err := s.client.connection.NewStream(callContext, stepPoolDescription, stepPoolMethod,
		grpc.WaitForReady(waitForReady))
	gaveUp := stop()
	if err != nil || gaveUp {
		cancel()
		if gaveUp {
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
		err = newError(codes.Internal, "%s answered something else than that it is attached", s.attach.Pool)
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

// Goes on with a new connection, or tells why that cannot be.
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
			err = s.checkStandsWhereLeft(attached)
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

func (s *stream) checkStandsWhereLeft(attached *pb.Attached) error {
	least := s.unanswered[0].SequenceNumber
	if at := attached.NextSequenceNumber; at < least || at > s.next {
		return newError(codes.Aborted, "%s is at request %d, and this stream left it between %d and %d: somebody else has "+
			"stepped it, or it is another pool of the same name", s.attach.Pool, at, least, s.next)
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
		// gRPC's words where a connection was reset, or ended, in the midst of a stream.
		said := fmt.Sprint(err)
		return strings.Contains(said, "RST_STREAM") || strings.Contains(said, "EOF") || strings.Contains(said, "transport")
	}
	return false
}

// Calls cancel when ctx ends before the function that it gives is called, which tells whether that was so.
func giveUpWith(ctx context.Context, cancel func()) (stop func() (gaveUp bool)) {
	if ctx.Done() == nil {
		return func() bool { return false }
	}
	done := make(chan struct{})
	gaveUp := make(chan bool)
	go func() {
		select {
		case <-ctx.Done():
			cancel()
			gaveUp <- true
		case <-done:
			gaveUp <- false
		}
	}()
	return func() bool {
		close(done)
		return <-gaveUp
	}
}

func minDuration(a, b time.Duration) time.Duration {
	if a < b {
		return a
	}
	return b
}
