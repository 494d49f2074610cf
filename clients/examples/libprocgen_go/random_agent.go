// A random agent over the C ABI: random_agent ADDRESS STEPS. "" as ADDRESS: in this process.
package main

// #include <stdlib.h>
// #include "procgen_remote.h"
import "C"

import (
	"fmt"
	"log"
	"math/rand"
	"os"
	"runtime"
	"strconv"
	"unsafe"
)

const (
	envCount         = 4
	observationBytes = 64 * 64 * 3
)

func check(code C.ProcgenCode) {
	if code != C.PROCGEN_OK {
		log.Fatal(C.GoString(C.procgen_error_message()))
	}
}

func main() {
	runtime.LockOSThread() // An error message belongs to the thread of the failed call.
	steps, err := strconv.Atoi(os.Args[2])
	if err != nil {
		log.Fatal(err)
	}
	var pinner runtime.Pinner // C may keep pointers to pinned memory.
	defer pinner.Unpin()

	game := C.CString("coinrun")
	defer C.free(unsafe.Pointer(game))
	var options C.ProcgenPoolOptions
	C.procgen_pool_options_init(&options, C.sizeof_ProcgenPoolOptions)
	pinner.Pin(&game)
	options.games = &game
	options.game_count = 1
	options.env_count = envCount
	options.rand_seed = 1
	options.has_rand_seed = 1
	var connection *C.ProcgenConnection
	var pool *C.ProcgenPool
	if os.Args[1] == "" {
		check(C.procgen_pool_create(&options, &pool))
	} else {
		address := C.CString(os.Args[1])
		defer C.free(unsafe.Pointer(address))
		check(C.procgen_connect(address, nil, &connection))
		check(C.procgen_connection_create_pool(connection, &options, nil, &pool))
	}

	var values struct {
		observations          [envCount * observationBytes]C.uint8_t // [4, 64, 64, 3]
		terminated, truncated [envCount]C.uint8_t
		episodeReturns        [envCount]C.float
		actions               [envCount]C.int32_t
	}
	pinner.Pin(&values)
	batch := C.ProcgenBatch{ // Null arrays are not written.
		struct_size:     C.sizeof_ProcgenBatch,
		observations:    &values.observations[0],
		terminated:      &values.terminated[0],
		truncated:       &values.truncated[0],
		episode_returns: &values.episodeReturns[0],
	}
	step := C.ProcgenStep{
		struct_size: C.sizeof_ProcgenStep, env_count: envCount, actions: &values.actions[0],
	}
	random := rand.New(rand.NewSource(1))
	count, sum := 0, 0.0
	for range steps {
		for env := range values.actions {
			values.actions[env] = C.int32_t(random.Intn(C.PROCGEN_ACTION_COUNT))
		}
		check(C.procgen_step(pool, &step, &batch))
		for env, value := range values.episodeReturns {
			if values.terminated[env]+values.truncated[env] > 0 {
				count++
				sum += float64(value)
			}
		}
	}
	C.procgen_pool_destroy(pool)
	C.procgen_connection_destroy(connection)
	fmt.Printf("%d episodes, mean return %.3f\n", count, sum/float64(count))
}
