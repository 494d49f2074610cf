// Package procgenclient steps pools of Procgen environments on a Procgen Server. Messages are the contract's
// (procgenclient/procgenv1, whose comments are the manual); README.md shows how it is used.
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

// Options is what a client connects with; the zero value will do.
type Options struct {
	// How long a pool's stream whose connection broke tries to go on, each time; the server keeps its answers meanwhile.
	// Negative: a broken connection ends the stream, and the server keeps nothing. 0: 60 seconds.
	ReconnectTimeout time.Duration
	// For a server that speaks TLS or asks who calls. nil: what the environment says (CredentialsFromEnvironment).
	Credentials *Credentials
}

// Client is a connection to a server, over which pools are made and stepped. Its methods may be called from any goroutine.
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

// Connect connects to a server: "localhost:50051", "unix:/run/procgen.sock". One that is just starting is waited for, for 10
// seconds unless ctx says otherwise; UNAVAILABLE: none answered.
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

// Address is what it is connected to.
func (c *Client) Address() string { return c.address }

// Close closes the connection; pools stay on the server until they are deleted.
func (c *Client) Close() error { return c.connection.Close() }

// Catalog is what the server offers: games, modes, options, actions, limits. It does not change while the server runs, so it
// was asked for once, on connecting.
func (c *Client) Catalog() *pb.Catalog { return c.catalog }

// Load tells how busy the server is at this moment.
func (c *Client) Load(ctx context.Context) (*pb.Load, error) {
	load, err := c.catalogs.GetLoad(c.with(ctx), &pb.GetLoadRequest{})
	return load, fromRPC(ctx, err)
}

// CreatePool makes a pool; every environment stands at the first step of its first level. poolID: the last part of its
// name; empty: the server chooses.
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

// GetPool gives a pool that is there already.
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

// ListPools tells what pools the caller owns, oldest first.
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

// DeletePool ends a pool and frees its environments; a stream that is attached to it ends with ABORTED.
func (c *Client) DeletePool(ctx context.Context, name string) error {
	_, err := c.pools.DeletePool(c.with(ctx), &pb.DeletePoolRequest{Name: name})
	return fromRPC(ctx, err)
}

// What each call bears.
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
		return nil, newError(codes.Internal, "the server at %s tells of no games", c.address)
	}
	return catalog, nil
}

// Why the connection fails, in gRPC's words.
func (c *Client) reason() string {
	ctx, cancel := context.WithTimeout(context.Background(), reasonTimeout)
	defer cancel()
	if _, err := c.catalogs.GetCatalog(c.with(ctx), &pb.GetCatalogRequest{}); err != nil {
		return fromRPC(context.Background(), err).(*Error).Message
	}
	return "it has just begun to"
}

// For gRPC a unix socket is an address that the dialer knows.
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
		// Attach tells the server how large responses may be, and far less is usual. This is what one that does not care
		// can make this process take.
		grpc.WithDefaultCallOptions(
			grpc.MaxCallRecvMsgSize(256<<20), grpc.MaxCallSendMsgSize(1<<30), grpc.ForceCodec(codec{})),
		// A whole response is on its way at once, and not a window of 64 KiB after the other.
		grpc.WithInitialWindowSize(8 << 20),
		grpc.WithInitialConnWindowSize(8 << 20),
		// A connection that is silent is asked for a sign of life, so that a dead one is found.
		grpc.WithKeepaliveParams(keepalive.ClientParameters{Time: keepaliveTime, Timeout: keepaliveTimeout}),
		// A server that is just starting is found soon.
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
