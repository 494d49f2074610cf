package procgenclient

// Connections to a real server: catalog, pools by name, states, errors, unix sockets, tokens, TLS.

import (
	"bytes"
	"context"
	"os"
	"os/exec"
	"path/filepath"
	"testing"
	"time"

	"google.golang.org/grpc/codes"
	"google.golang.org/protobuf/types/known/durationpb"

	pb "procgenclient/procgenv1"
)

func TestCatalogContainsGamesAndLimits(t *testing.T) {
	client := connected(t, Options{})
	if games, actions := len(client.Catalog().Games), len(client.Catalog().Actions); games != 16 || actions != 15 {
		t.Error(games, actions)
	}
	load, err := client.Load(testContext(t))
	must(t, err)
	if load.Draining {
		t.Error(load)
	}
}

func TestPoolsAreCreatedFoundListedRenewedAndDeleted(t *testing.T) {
	ctx := testContext(t)
	client := connected(t, Options{})
	spec := easy(2, "maze")
	spec.LeaseDuration = durationpb.New(90 * time.Second)
	pool, err := client.CreatePool(ctx, "mine", spec, PoolOptions{})
	must(t, err)
	_, err = client.CreatePool(ctx, "mine", spec, PoolOptions{})
	expectError(t, err, codes.AlreadyExists)
	found, err := client.GetPool(ctx, "pools/mine", PoolOptions{})
	must(t, err)
	if found.Spec().Options.GetRandSeed() != 5 {
		t.Error(found.Spec())
	}
	for _, renewal := range []struct{ given, lease time.Duration }{{time.Hour, time.Hour}, {KeepLease, time.Hour}, {0, 0}} {
		must(t, pool.Renew(ctx, renewal.given))
		pools, err := client.ListPools(ctx)
		must(t, err)
		renewed := false
		for _, message := range pools {
			renewed = renewed || message.Name == "pools/mine" && message.Spec.LeaseDuration.AsDuration() == renewal.lease
		}
		if !renewed {
			t.Error(renewal, pools)
		}
	}
	expectError(t, pool.Renew(ctx, time.Millisecond), codes.InvalidArgument)
	expectError(t, pool.Renew(ctx, 25*time.Hour), codes.ResourceExhausted)
	must(t, pool.Delete(ctx))
	expectError(t, client.DeletePool(ctx, "pools/mine"), codes.NotFound)
}

func TestErrorsKeepTheServersMessage(t *testing.T) {
	client := connected(t, Options{})
	_, err := client.CreatePool(testContext(t), "", easy(1, "pong"), PoolOptions{})
	expectError(t, err, codes.NotFound, "pong")
	_, err = client.CreatePool(testContext(t), "", easy(0, "maze"), PoolOptions{})
	expectError(t, err, codes.InvalidArgument)
	_, err = client.CreatePool(testContext(t), "", easy(1, "maze"), PoolOptions{ChunkCount: 65})
	expectError(t, err, codes.InvalidArgument, "ChunkCount is 65")
}

func TestConnectWithoutServerTimesOut(t *testing.T) {
	ctx, cancel := context.WithTimeout(context.Background(), 300*time.Millisecond)
	defer cancel()
	_, err := Connect(ctx, "127.0.0.1:1", Options{})
	expectError(t, err, codes.Unavailable, "127.0.0.1:1")
}

func TestUnixSocketsAreSupported(t *testing.T) {
	socket := "unix:" + filepath.Join(t.TempDir(), "socket")
	own, err := StartServer("", "--workers=1", "--address="+socket)
	must(t, err)
	client, err := Connect(testContext(t), own.Address, Options{})
	must(t, err)
	stepped(t, madePool(t, client, easy(1, "maze"), PoolOptions{}), []int32{4}, StepOptions{})
	must(t, client.Close())
	must(t, own.Stop())
}

func TestRestoredStatesContinueAsTheOriginals(t *testing.T) {
	ctx := testContext(t)
	pool := madePool(t, connected(t, Options{}), easy(80, "bigfish", "maze"), PoolOptions{})
	for step := 0; step < 5; step++ {
		stepped(t, pool, actionsOf(step, 80), StepOptions{})
	}
	states, err := pool.SaveStates(ctx)
	must(t, err)
	size := 0
	for _, state := range states {
		size += len(state.Snapshot)
	}
	if len(states) != 80 || size <= int(pool.client.Catalog().Limits.RequestBytesMax) {
		t.Fatal("all states fit one request", len(states), size)
	}
	before := stepped(t, pool, actionsOf(9, 80), StepOptions{})
	must(t, pool.RestoreStates(ctx, states))
	after := stepped(t, pool, actionsOf(9, 80), StepOptions{})
	if !bytes.Equal(after.Observations, before.Observations) {
		t.Error("the restored pool continues differently")
	}
	damaged := &pb.State{Snapshot: append([]byte(nil), states[0].Snapshot...)}
	damaged.Snapshot[len(damaged.Snapshot)-1] ^= 1
	expectError(t, pool.RestoreStates(ctx, []*pb.State{damaged}), codes.DataLoss)
	must(t, pool.SendStep(ctx, actionsOf(0, 80), StepOptions{}))
	_, err = pool.SaveStates(ctx)
	expectError(t, err, codes.FailedPrecondition)
}

func TestEnvironmentsAreClonedAndDrawn(t *testing.T) {
	ctx := testContext(t)
	client := connected(t, Options{})
	pool := madePool(t, client, easy(7, "maze"), PoolOptions{})
	other := madePool(t, client, easy(3, "maze"), PoolOptions{})
	must(t, pool.CloneStates(ctx, CloneSource{}, &pb.ClonePair{SourceEnvironment: 0, TargetEnvironment: 6}))
	must(t, pool.CloneStates(ctx, CloneSource{Pool: other.Name()}, &pb.ClonePair{SourceEnvironment: 2, TargetEnvironment: 1}))
	batch, err := pool.Observe(ctx, Slice{})
	must(t, err)
	if !bytes.Equal(batch.Observation(6), batch.Observation(0)) || !bytes.Equal(batch.Observation(1), batch.Observation(2)) {
		t.Error(batch.LevelSeeds)
	}
	frames, err := pool.Render(ctx, 512)
	must(t, err)
	if len(frames) != 7 || len(frames[6].Image) != 512*512*3 {
		t.Error(len(frames))
	}
	_, err = pool.Render(ctx, 8)
	expectError(t, err, codes.InvalidArgument, "sizePx is 8, allowed: 16 to 2048")
	_, err = pool.Render(ctx, 64, 7)
	expectError(t, err, codes.InvalidArgument)
}

func makeCertificates(t *testing.T) (path func(string) string) {
	folder := t.TempDir()
	path = func(name string) string { return filepath.Join(folder, name) }
	openssl := func(arguments ...string) {
		command := exec.Command("openssl", arguments...)
		command.Dir = folder
		if said, err := command.CombinedOutput(); err != nil {
			t.Fatalf("%v: %s", err, said)
		}
	}
	key := []string{"req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"}
	openssl(append(key, "-x509", "-keyout", "ca.key", "-out", "ca.pem", "-subj", "/CN=authority", "-days", "2")...)
	must(t, os.WriteFile(path("names"), []byte("subjectAltName=IP:127.0.0.1\n"), 0o600))
	for _, name := range []string{"server", "client"} {
		openssl(append(key, "-keyout", name+".key", "-out", name+".csr", "-subj", "/CN="+name)...)
		openssl("x509", "-req", "-in", name+".csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial",
			"-out", name+".pem", "-days", "2", "-extfile", "names")
	}
	return path
}

func TestTLSClientCertificatesAndTokensAreSentAsRequired(t *testing.T) {
	ctx := testContext(t)
	path := makeCertificates(t)
	const token = "0123456789abcdef0123456789abcdef"
	must(t, os.WriteFile(path("tokens"), []byte("alice "+token+"\n"), 0o600))
	own, err := StartServer("", "--workers=1", "--tls_certificate="+path("server.pem"), "--tls_key="+path("server.key"),
		"--tls_client_ca="+path("ca.pem"), "--tokens="+path("tokens"))
	must(t, err)
	shown := Credentials{CA: path("ca.pem"), Certificate: path("client.pem"), Key: path("client.key"), Token: token}
	client, err := Connect(ctx, own.Address, Options{Credentials: &shown})
	must(t, err)
	pool, err := client.CreatePool(ctx, "of-alice", easy(1, "maze"), PoolOptions{})
	must(t, err)
	stepped(t, pool, []int32{4}, StepOptions{})
	pools, err := client.ListPools(ctx)
	must(t, err)
	if len(pools) != 1 || pools[0].Owner != "alice" {
		t.Error(pools)
	}
	must(t, pool.Delete(ctx))
	must(t, client.Close())
	wrong := shown
	wrong.Token = "wrong"
	_, err = Connect(ctx, own.Address, Options{Credentials: &wrong})
	expectError(t, err, codes.Unauthenticated)
	for _, too := range []Credentials{{CA: path("ca.pem"), Token: token}, {Token: token}} {
		brief, cancel := context.WithTimeout(ctx, 500*time.Millisecond)
		_, err = Connect(brief, own.Address, Options{Credentials: &too})
		cancel()
		expectError(t, err, codes.Unavailable)
	}
	must(t, own.Stop())
}

func TestCredentialsAreNotSentInsecurely(t *testing.T) {
	for words, shown := range map[string]Credentials{
		"would go to 127.0.0.1.example.com:1 in plain text": {Token: "secret"},
		"give both or none":   {Certificate: "client.pem"},
		"give CA":             {Certificate: "client.pem", Key: "client.key"},
		"no such file":        {CA: "/nowhere/ca.pem"},
		"no certificate":      {CA: os.Args[0]},
		"/nowhere/client.pem": {CA: "/etc/ssl/certs/ca-certificates.crt", Certificate: "/nowhere/client.pem", Key: "key"},
	} {
		shown := shown
		if _, err := Connect(testContext(t), "127.0.0.1.example.com:1", Options{Credentials: &shown}); err == nil {
			t.Error("no error; expected:", words)
		} else if shown.CA != "/etc/ssl/certs/ca-certificates.crt" {
			expectError(t, err, err.(*Error).Code, words)
		}
	}
}
