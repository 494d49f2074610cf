package procgenclient

import (
	"context"

	pb "procgenclient/procgenv1"
)

// ListNodes returns the servers of the cluster, or this server if it is in none.
func (c *Client) ListNodes(ctx context.Context) (*pb.ListNodesResponse, error) {
	nodes, err := c.clusters.ListNodes(c.with(ctx), &pb.ListNodesRequest{})
	return nodes, fromRPC(ctx, err)
}

// WatchNodes calls yield with the servers of the cluster now, and again after each change. It
// returns nil when yield returns false, and UNAVAILABLE when the server stops or the connection
// breaks.
func (c *Client) WatchNodes(ctx context.Context, yield func(*pb.WatchNodesResponse) bool) error {
	callContext, cancel := context.WithCancel(c.with(ctx))
	defer cancel()
	call, err := c.clusters.WatchNodes(callContext, &pb.WatchNodesRequest{})
	if err != nil {
		return fromRPC(ctx, err)
	}
	return watch(ctx, call.Recv, yield)
}
