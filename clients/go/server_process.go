package procgenclient

import (
	"bufio"
	"os"
	"os/exec"
	"strings"
	"syscall"
	"time"

	"google.golang.org/grpc/codes"
)

// ServerProcess is a local procgen-server process. Its log lines are discarded.
type ServerProcess struct {
	// Address is where it listens, for Connect.
	Address string
	// Process is the operating system's process.
	Process *os.Process

	exited chan error
}

// StartServer starts a server and waits until it listens. binary is the program; empty:
// PROCGEN_SERVER_BINARY, else procgen-server in PATH. It listens on a free port of 127.0.0.1 unless
// a flag sets another address. UNAVAILABLE: it cannot be started, or has ended.
func StartServer(binary string, flags ...string) (*ServerProcess, error) {
	if binary == "" {
		binary = os.Getenv("PROCGEN_SERVER_BINARY")
	}
	if binary == "" {
		binary = "procgen-server"
	}
	command := exec.Command(binary, append([]string{"--address=127.0.0.1:0"}, flags...)...)
	output, err := command.StdoutPipe()
	if err != nil {
		return nil, newError(codes.Internal, "%v", err)
	}
	if err := command.Start(); err != nil {
		return nil, newError(codes.Unavailable, "%s cannot be started: %v", binary, err)
	}
	server := &ServerProcess{Process: command.Process, exited: make(chan error, 1)}
	late := time.AfterFunc(startTimeout, func() { _ = command.Process.Kill() })
	// Its standard output is one line with the address.
	line, err := bufio.NewReader(output).ReadString('\n')
	late.Stop()
	go func() { server.exited <- command.Wait() }()
	if err != nil {
		return nil, newError(codes.Unavailable, "%s ended: %v", binary, <-server.exited)
	}
	server.Address = strings.TrimSpace(strings.TrimPrefix(line, "listening on "))
	return server, nil
}

// Stop stops the server: SIGTERM, and SIGKILL after 15 seconds. It returns an error unless the exit
// status is 0.
func (s *ServerProcess) Stop() error {
	_ = s.Process.Signal(syscall.SIGTERM)
	late := time.AfterFunc(stopTimeout, func() { _ = s.Process.Kill() })
	defer late.Stop()
	err := <-s.exited
	s.exited <- err // For further calls.
	return err
}
