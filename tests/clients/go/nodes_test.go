package procgenclient

// Nodes of a cluster.

import (
	"context"
	"errors"
	"testing"

	"google.golang.org/grpc/codes"

	pb "procgenclient/procgenv1"
)

func TestServerWithoutAClusterListsItself(t *testing.T) {
	client := connected(t, Options{})
	nodes, err := client.ListNodes(testContext(t))
	must(t, err)
	if len(nodes.Nodes) != 1 || nodes.Cluster != "" || nodes.Nodes[0].Name != nodes.LocalNode {
		t.Fatal(nodes)
	}
	if node := nodes.Nodes[0]; node.Address != client.Address() || node.Role != pb.NodeRole_NODE_ROLE_HOST || !node.Healthy {
		t.Error(node)
	}
}

func TestWatchersReceiveEachChange(t *testing.T) {
	client := connected(t, Options{})
	const many = 1000 // More than pools of other tests, which may still be reported.
	reported := 0
	must(t, client.WatchNodes(testContext(t), func(nodes *pb.WatchNodesResponse) bool {
		count := nodes.Nodes[0].EnvCount
		if reported++; reported == 1 {
			if count >= many {
				t.Error(count, "environments before the first was created")
			}
			madePool(t, client, easy(many, "maze"), PoolOptions{})
		}
		return count < many
	}))
}

func TestContextEndsAWatcher(t *testing.T) {
	client := connected(t, Options{})
	ctx, cancel := context.WithCancel(testContext(t))
	err := client.WatchNodes(ctx, func(*pb.WatchNodesResponse) bool {
		cancel()
		return true
	})
	expectError(t, err, codes.Canceled)
	if !errors.Is(err, context.Canceled) {
		t.Error(err)
	}
}

func TestWatchersAreNotifiedWhenTheServerStops(t *testing.T) {
	stopping, err := StartServer("", "--workers=1")
	must(t, err)
	client, err := Connect(testContext(t), stopping.Address, Options{})
	must(t, err)
	defer client.Close()
	err = client.WatchNodes(testContext(t), func(*pb.WatchNodesResponse) bool {
		go stopping.Stop()
		return true
	})
	expectError(t, err, codes.Unavailable)
	must(t, stopping.Stop())
}
