package procgenclient

// The examples and the examples of README.md run.

import (
	"fmt"
	"os"
	"os/exec"
	"path/filepath"
	"regexp"
	"strings"
	"testing"
)

// Runs a main package that uses this package; returns its output.
func goRun(t *testing.T, arguments ...string) string {
	t.Helper()
	said, err := exec.Command("go", append([]string{"run"}, arguments...)...).CombinedOutput()
	if err != nil {
		t.Fatalf("%v: %s", err, said)
	}
	return string(said)
}

func TestRandomAgentPlays(t *testing.T) {
	said := goRun(t, "procgenclient/examples/random_agent", "-server", server.Address, "-game", "maze")
	if !regexp.MustCompile(`^\d+ episodes of maze\n$`).MatchString(said) {
		t.Error(said)
	}
}

func TestRandomAgentFailsWithTheReason(t *testing.T) {
	agent := exec.Command("go", "run", "procgenclient/examples/random_agent", "-server", server.Address, "-game", "pong")
	said, err := agent.CombinedOutput()
	if err == nil || !strings.Contains(string(said), `no game is named "pong"`) {
		t.Errorf("%v: %s", err, said)
	}
}

const program = `package main

import (
	"context"
	"fmt"
	"log"

	"procgenclient"
	pb "procgenclient/procgenv1"
)

var _, _ = fmt.Println, pb.File_procgen_v1_step_proto

func main() {
	if err := run(context.Background()); err != nil {
		log.Fatal(err)
	}
}

func run(ctx context.Context) error {
%s
	return nil
}
`

func TestReadmeExamplesRun(t *testing.T) {
	folder := os.Getenv("PROCGEN_GO_CLIENT")
	if folder == "" {
		t.Skip("set PROCGEN_GO_CLIENT to clients/go")
	}
	readme, err := os.ReadFile(filepath.Join(folder, "README.md"))
	must(t, err)
	examples := regexp.MustCompile("(?sm)^```go\n(.*?)^```$").FindAllStringSubmatch(string(readme), -1)
	if len(examples) < 3 {
		t.Fatal("README.md has", len(examples), "examples")
	}
	for i, example := range examples {
		t.Run(fmt.Sprint(i), func(t *testing.T) {
			if !strings.Contains(example[1], `"localhost:50051"`) {
				t.Error("the example has no server address")
			}
			code := strings.ReplaceAll(example[1], "localhost:50051", server.Address)
			file := filepath.Join(t.TempDir(), "main.go")
			must(t, os.WriteFile(file, []byte(fmt.Sprintf(program, code)), 0o600))
			goRun(t, file)
		})
	}
}
