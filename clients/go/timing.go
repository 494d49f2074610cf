package procgenclient

import "time"

// How long this client waits: all its time limits and retry backoff.

const (
	connectTimeoutDefault   = 10 * time.Second // Of Connect, whose context has no deadline.
	reconnectTimeoutDefault = 60 * time.Second // Options.ReconnectTimeout.
	reasonTimeout           = time.Second      // Of the call that asks why a server cannot be reached.

	keepaliveTime    = 20 * time.Second // Idle time after which a ping is sent.
	keepaliveTimeout = 10 * time.Second // Time in which it must be answered.

	// Between tries to resume a stream: doubled from try to try, times a random factor in [0.5, 1.5).
	backoffMin = 20 * time.Millisecond
	backoffMax = 2 * time.Second

	// Between gRPC's tries to connect.
	channelBackoffMin     = 20 * time.Millisecond
	channelBackoffMax     = time.Second
	channelConnectTimeout = 5 * time.Second // Of a try, at least.

	startTimeout = 30 * time.Second // Of a ServerProcess, until it listens.
	stopTimeout  = 15 * time.Second // Until it has stopped; then it is killed.
)
