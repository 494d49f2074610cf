package procgenclient

import (
	"context"

	pb "procgenclient/procgenv1"
)

// Pictures of environments, for people: once, or as they change.

// What a response of frames has besides their pixels, at most: once, and for each. In bytes.
const framesOverheadBytes = 4096
const frameOverheadBytes = 64

// What is watched where nobody tells what: so many environments, and so many pixels wide.
const watchedDefault = 16
const watchedSizePxDefault = 256

// Render draws environments for people (all, unless told which), in squares of sizePx pixels, 16 to 2048: RGB, top row first.
func (p *Pool) Render(ctx context.Context, sizePx int32, environments ...int32) ([]*pb.Frame, error) {
	if sizePx < 16 || sizePx > 2048 {
		return nil, invalid("sizePx is %d; it is in [16, 2048]", sizePx)
	}
	if len(environments) == 0 {
		environments = firstEnvs(p.EnvCount())
	}
	roomBytes := clamp(int(p.client.catalog.Limits.ResponseBytesMax), 0, responseBytesDefault) - framesOverheadBytes
	atATime := clamp(roomBytes/frameBytes(sizePx), 1, len(environments))
	var frames []*pb.Frame
	for len(environments) > 0 {
		count := clamp(atATime, 1, len(environments))
		answer, err := p.client.renders.RenderEnvironments(p.client.with(ctx), &pb.RenderEnvironmentsRequest{
			Pool:             p.Name(),
			Environments:     environments[:count],
			SizePx:           sizePx,
			Format:           pb.FrameFormat_FRAME_FORMAT_RGB,
			ResponseBytesMax: framesBytesMax(count, sizePx),
		})
		if err != nil {
			return nil, fromRPC(ctx, err)
		}
		if err := checkFrames(answer.Frames, environments[:count], sizePx); err != nil {
			return nil, err
		}
		frames = append(frames, answer.Frames...)
		environments = environments[count:]
	}
	return frames, nil
}

// WatchOptions is what is watched, and how; the zero value will do.
type WatchOptions struct {
	// Environments in the order wanted, at most 64. Empty: the first 16.
	Environments []int32
	// Side of the square frames in pixels, in [16, 2048]; 64: what the agent sees, pixel by pixel. 0: 256.
	SizePx int32
	// Moments in a second at most, above 0 and at most 60. 0: 15.
	FramesPerSecondMax float32
}

// Watch shows environments while somebody steps them, and never slows who does: it calls `yield` with frames (RGB, top row
// first) of how they are now, and then of how they are after something has changed, at a bounded rate. What changes while
// `yield` is busy is left out, but for the latest. It ends with nil when `yield` gives false, with ABORTED when the pool is gone,
// and with UNAVAILABLE when the server stops or the connection breaks.
func (p *Pool) Watch(ctx context.Context, options WatchOptions, yield func(*pb.WatchPoolResponse) bool) error {
	environments, sizePx := options.Environments, options.SizePx
	if len(environments) == 0 {
		environments = firstEnvs(clamp(p.EnvCount(), 1, watchedDefault))
	}
	if sizePx == 0 {
		sizePx = watchedSizePxDefault
	}
	callContext, cancel := context.WithCancel(p.client.with(ctx))
	defer cancel()
	call, err := p.client.renders.WatchPool(callContext, &pb.WatchPoolRequest{
		Pool:               p.Name(),
		Environments:       environments,
		SizePx:             sizePx,
		Format:             pb.FrameFormat_FRAME_FORMAT_RGB,
		FramesPerSecondMax: options.FramesPerSecondMax,
		ResponseBytesMax:   framesBytesMax(len(environments), sizePx),
	})
	if err != nil {
		return fromRPC(ctx, err)
	}
	var invalid error
	err = watch(ctx, call.Recv, func(moment *pb.WatchPoolResponse) bool {
		invalid = checkFrames(moment.Frames, environments, sizePx)
		return invalid == nil && yield(moment)
	})
	if invalid != nil {
		return invalid
	}
	return err
}

func firstEnvs(count int) []int32 {
	environments := make([]int32, count)
	for i := range environments {
		environments[i] = int32(i)
	}
	return environments
}

func frameBytes(sizePx int32) int {
	return 3*int(sizePx)*int(sizePx) + frameOverheadBytes
}

// The largest response of so many frames: no more than they take, as a server may have a low limit. 0: what it sends by
// default.
func framesBytesMax(count int, sizePx int32) int64 {
	bytes := framesOverheadBytes + count*frameBytes(sizePx)
	if bytes <= responseBytesDefault {
		return 0
	}
	return int64(bytes)
}
