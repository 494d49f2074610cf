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

// ServerProcess is a procgen-server that is started on this machine, and stopped by Stop. Its log lines are thrown away.
type ServerProcess struct {
	// Where it listens, for Connect.
	Address string
	// The process itself.
	Process *os.Process

	exited chan error
}

// StartServer starts a program ("": what PROCGEN_SERVER_BINARY says, else procgen-server in PATH), on a port of loopback
// that the system chooses unless a flag says otherwise, and waits until it listens.
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
	// It writes the address that it is bound to on its standard output, and nothing else.
	line, err := bufio.NewReader(output).ReadString('\n')
	late.Stop()
	go func() { server.exited <- command.Wait() }()
	if err != nil {
		return nil, newError(codes.Unavailable, "%s ended: %v", binary, <-server.exited)
	}
	server.Address = strings.TrimSpace(strings.TrimPrefix(line, "listening on "))
	return server, nil
}

// Stop asks it to drain and end, and waits; kills it after a while. The error tells how it ended, if not well.
func (s *ServerProcess) Stop() error {
	_ = s.Process.Signal(syscall.SIGTERM)
	late := time.AfterFunc(stopTimeout, func() { _ = s.Process.Kill() })
	defer late.Stop()
	err := <-s.exited
	s.exited <- err // For who stops it again.
	return err
}
