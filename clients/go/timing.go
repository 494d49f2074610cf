package procgenclient

import "time"

// All time limits and retry backoffs of this client.

const (
	connectTimeoutDefault   = 10 * time.Second // Of Connect with a context without deadline.
	reconnectTimeoutDefault = 60 * time.Second // Of Options.ReconnectTimeout.
	reasonTimeout           = time.Second      // Of the call that gets the reason for a failed connection.

	keepaliveTime    = 20 * time.Second // Idle time after which the client sends a keepalive ping.
	keepaliveTimeout = 10 * time.Second // Time that the server has to answer it.

	// Backoff between attempts to resume a stream: doubles each time, with a random factor in [0.5,
	// 1.5).
	backoffMin = 20 * time.Millisecond
	backoffMax = 2 * time.Second

	// Backoff between gRPC's attempts to connect.
	channelBackoffMin     = 20 * time.Millisecond
	channelBackoffMax     = time.Second
	channelConnectTimeout = 5 * time.Second // Minimum of one attempt.

	startTimeout = 30 * time.Second // Time that a ServerProcess has until it listens.
	stopTimeout  = 15 * time.Second // Time that it has to stop before it is killed.
)
