package procgenclient

import (
	"context"

	pb "procgenclient/procgenv1"
)

// ListNodes tells which servers there are in the server's cluster; it alone where it has none.
func (c *Client) ListNodes(ctx context.Context) (*pb.ListNodesResponse, error) {
	nodes, err := c.clusters.ListNodes(c.with(ctx), &pb.ListNodesRequest{})
	return nodes, fromRPC(ctx, err)
}

// WatchNodes calls `yield` with the servers that there are: at first as they are now, then as they are after a change. It ends
// with nil when `yield` gives false, and with UNAVAILABLE when the server stops or the connection breaks.
func (c *Client) WatchNodes(ctx context.Context, yield func(*pb.WatchNodesResponse) bool) error {
	callContext, cancel := context.WithCancel(c.with(ctx))
	defer cancel()
	call, err := c.clusters.WatchNodes(callContext, &pb.WatchNodesRequest{})
	if err != nil {
		return fromRPC(ctx, err)
	}
	return watch(ctx, call.Recv, yield)
}
