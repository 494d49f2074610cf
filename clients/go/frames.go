package procgenclient

import (
	"context"

	pb "procgenclient/procgenv1"
)

// Frames of environments for people: rendered once, or streamed.

// Upper bound of a response of frames without the pixels, in bytes: once, and for each frame.
const framesOverheadBytes = 4096
const frameOverheadBytes = 64

// Defaults of Watch: number of environments, and size in pixels.
const watchedDefault = 16
const watchedSizePxDefault = 256

// Render renders environments (none given: all) for people: RGB, top row first, sizePx pixels a
// side, 16 to 2048.
func (p *Pool) Render(ctx context.Context, sizePx int32, environments ...int32) ([]*pb.Frame, error) {
	if sizePx < 16 || sizePx > 2048 {
		return nil, invalid("sizePx is %d, allowed: 16 to 2048", sizePx)
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

// WatchOptions configures Watch. The zero value selects the defaults.
type WatchOptions struct {
	// Environments to watch, in this order, at most 64. Empty: the first 16.
	Environments []int32
	// SizePx is the side of the square frames in pixels, in [16, 2048]; 64: the agent's observation,
	// pixel by pixel. 0: 256.
	SizePx int32
	// FramesPerSecondMax is the maximum number of responses per second, in (0, 60]. 0: 15.
	FramesPerSecondMax float32
}

// Watch calls yield with frames of environments (RGB, top row first) now, and again after each
// change, at a bounded rate, without slowing the learner. While yield runs, intermediate frames are
// skipped. Watch returns nil when yield returns false. It returns ABORTED when the pool is deleted
// or its lease expires, and UNAVAILABLE when the server stops or the connection breaks.
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

// Returns the largest response of `count` frames: no more than needed, because a server may have a
// low limit. 0: the default.
func framesBytesMax(count int, sizePx int32) int64 {
	bytes := framesOverheadBytes + count*frameBytes(sizePx)
	if bytes <= responseBytesDefault {
		return 0
	}
	return int64(bytes)
}
