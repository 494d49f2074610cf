// Package procgenclient steps pools of Procgen environments on a Procgen Server. Requests and
// responses are the messages of proto/procgen/v1, generated into procgenclient/procgenv1 with their
// documentation. README.md has examples.
package procgenclient

import (
	"context"
	"net"
	"strings"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/backoff"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/credentials"
	"google.golang.org/grpc/keepalive"
	"google.golang.org/grpc/metadata"

	pb "procgenclient/procgenv1"
)

// Options configures Connect. The zero value selects the defaults.
type Options struct {
	// ReconnectTimeout is the time that a pool's stream tries to resume after a broken connection. The
	// server keeps its answers meanwhile. Negative: a broken connection ends the stream, and the
	// server keeps nothing. 0: 60 seconds.
	ReconnectTimeout time.Duration
	// Credentials are the TLS certificates and the token. nil: CredentialsFromEnvironment.
	Credentials *Credentials
}

// Client is a connection to a server. It creates pools and returns existing ones. Its methods may
// be called from any goroutine.
type Client struct {
	address          string
	connection       *grpc.ClientConn
	reconnectTimeout time.Duration
	metadata         metadata.MD
	catalog          *pb.Catalog
	catalogs         pb.CatalogServiceClient
	pools            pb.PoolServiceClient
	states           pb.StateServiceClient
	renders          pb.RenderServiceClient
	clusters         pb.ClusterServiceClient
}

// Connect connects to a server: "localhost:50051", "unix:/run/procgen.sock". It waits for a server
// that is starting, until the deadline of ctx or for 10 seconds, and returns UNAVAILABLE if none
// answers.
func Connect(ctx context.Context, address string, options Options) (*Client, error) {
	shown := CredentialsFromEnvironment()
	if options.Credentials != nil {
		shown = *options.Credentials
	}
	dialOptions, err := dialOptions(address, shown)
	if err != nil {
		return nil, err
	}
	if _, given := ctx.Deadline(); !given {
		var cancel context.CancelFunc
		ctx, cancel = context.WithTimeout(ctx, connectTimeoutDefault)
		defer cancel()
	}
	connection, err := grpc.Dial(target(address), dialOptions...)
	if err != nil {
		return nil, newError(codes.InvalidArgument, "%s: %v", address, err)
	}
	client := &Client{
		address:          address,
		connection:       connection,
		reconnectTimeout: options.ReconnectTimeout,
		catalogs:         pb.NewCatalogServiceClient(connection),
		pools:            pb.NewPoolServiceClient(connection),
		states:           pb.NewStateServiceClient(connection),
		renders:          pb.NewRenderServiceClient(connection),
		clusters:         pb.NewClusterServiceClient(connection),
	}
	if client.reconnectTimeout == 0 {
		client.reconnectTimeout = reconnectTimeoutDefault
	}
	if shown.Token != "" {
		client.metadata = metadata.Pairs("authorization", "Bearer "+shown.Token)
	}
	if client.catalog, err = client.firstCatalog(ctx); err != nil {
		connection.Close()
		return nil, err
	}
	return client, nil
}

// Address returns the address passed to Connect.
func (c *Client) Address() string { return c.address }

// Close closes the connection. Pools stay on the server until they are deleted or their lease
// expires.
func (c *Client) Close() error { return c.connection.Close() }

// Catalog returns what the server offers: games, modes, options, actions, limits. It is constant
// while the server runs, and fetched once by Connect.
func (c *Client) Catalog() *pb.Catalog { return c.catalog }

// Load returns the current load of the server.
func (c *Client) Load(ctx context.Context) (*pb.Load, error) {
	load, err := c.catalogs.GetLoad(c.with(ctx), &pb.GetLoadRequest{})
	return load, fromRPC(ctx, err)
}

// CreatePool creates a pool; every environment is at the first step of its first level. poolID is
// the last part of its name; empty: the server chooses one.
func (c *Client) CreatePool(ctx context.Context, poolID string, spec *pb.PoolSpec, options PoolOptions) (*Pool, error) {
	message, err := c.pools.CreatePool(c.with(ctx), &pb.CreatePoolRequest{PoolId: poolID, Spec: spec})
	if err != nil {
		return nil, fromRPC(ctx, err)
	}
	name := ""
	if poolID != "" {
		name = "pools/" + poolID
	}
	if err := checkPool(message, name, spec.GetEnvCount()); err != nil {
		return nil, err
	}
	return newPool(c, message, options)
}

// GetPool returns an existing pool.
func (c *Client) GetPool(ctx context.Context, name string, options PoolOptions) (*Pool, error) {
	message, err := c.pools.GetPool(c.with(ctx), &pb.GetPoolRequest{Name: name})
	if err != nil {
		return nil, fromRPC(ctx, err)
	}
	if err := checkPool(message, name, 0); err != nil {
		return nil, err
	}
	return newPool(c, message, options)
}

// ListPools returns the caller's pools, oldest first.
func (c *Client) ListPools(ctx context.Context) ([]*pb.Pool, error) {
	var pools []*pb.Pool
	request := &pb.ListPoolsRequest{}
	for i := 0; i < poolPagesMax; i++ {
		page, err := c.pools.ListPools(c.with(ctx), request)
		if err != nil {
			return nil, fromRPC(ctx, err)
		}
		pools = append(pools, page.Pools...)
		if request.PageToken = page.NextPageToken; request.PageToken == "" {
			return pools, nil
		}
	}
	return nil, wrong("a list of pools of more than %d pages, expected: an end", poolPagesMax)
}

// DeletePool deletes a pool and frees its environments. An attached stream ends with ABORTED.
func (c *Client) DeletePool(ctx context.Context, name string) error {
	_, err := c.pools.DeletePool(c.with(ctx), &pb.DeletePoolRequest{Name: name})
	return fromRPC(ctx, err)
}

// Adds the metadata of each call.
func (c *Client) with(ctx context.Context) context.Context {
	if c.metadata == nil {
		return ctx
	}
	return metadata.NewOutgoingContext(ctx, c.metadata)
}

func (c *Client) firstCatalog(ctx context.Context) (*pb.Catalog, error) {
	catalog, err := c.catalogs.GetCatalog(c.with(ctx), &pb.GetCatalogRequest{}, grpc.WaitForReady(true))
	if ctx.Err() == context.DeadlineExceeded {
		return nil, newError(codes.Unavailable, "no server answers at %s (%s)", c.address, c.reason())
	}
	if err != nil {
		return nil, fromRPC(ctx, err)
	}
	if len(catalog.Games) == 0 {
		return nil, newError(codes.Internal, "the server at %s has a catalog without games", c.address)
	}
	return catalog, nil
}

// Returns gRPC's error text for the failed connection.
func (c *Client) reason() string {
	ctx, cancel := context.WithTimeout(context.Background(), reasonTimeout)
	defer cancel()
	if _, err := c.catalogs.GetCatalog(c.with(ctx), &pb.GetCatalogRequest{}); err != nil {
		return fromRPC(context.Background(), err).(*Error).Message
	}
	return "it has just started to answer"
}

// Returns gRPC's target for an address. Unix sockets are passed to the dialer below.
func target(address string) string {
	if strings.HasPrefix(address, "unix:") {
		return "passthrough:///" + address
	}
	return address
}

func dialOptions(address string, shown Credentials) ([]grpc.DialOption, error) {
	config, err := shown.tlsConfig(address)
	if err != nil {
		return nil, err
	}
	security := grpc.WithInsecure()
	if config != nil {
		security = grpc.WithTransportCredentials(credentials.NewTLS(config))
	}
	options := []grpc.DialOption{
		security,
		// Attach.response_bytes_max bounds responses far below this. It only protects against a server
		// that ignores it.
		grpc.WithDefaultCallOptions(
			grpc.MaxCallRecvMsgSize(256<<20), grpc.MaxCallSendMsgSize(1<<30), grpc.ForceCodec(codec{})),
		// Room for a whole response; the default window is 64 KiB.
		grpc.WithInitialWindowSize(8 << 20),
		grpc.WithInitialConnWindowSize(8 << 20),
		// Keepalive pings detect a dead connection.
		grpc.WithKeepaliveParams(keepalive.ClientParameters{Time: keepaliveTime, Timeout: keepaliveTimeout}),
		// Finds a server that is starting soon after it listens.
		grpc.WithConnectParams(grpc.ConnectParams{
			Backoff: backoff.Config{
				BaseDelay: channelBackoffMin, Multiplier: 1.6, Jitter: 0.2, MaxDelay: channelBackoffMax,
			},
			MinConnectTimeout: channelConnectTimeout,
		}),
	}
	if strings.HasPrefix(address, "unix:") {
		path := strings.TrimPrefix(strings.TrimPrefix(address, "unix:"), "//")
		options = append(options, grpc.WithAuthority("localhost"),
			grpc.WithContextDialer(func(ctx context.Context, _ string) (net.Conn, error) {
				return (&net.Dialer{}).DialContext(ctx, "unix", path)
			}))
	}
	return options, nil
}
