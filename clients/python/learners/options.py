"""Options of all learners: environments, duration, devices."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import torch

from learners import cpu, networks
from learners.networks import INITS, NETWORKS, default_precision
from procgen_client import ENV_NAMES

_OF_ONE_RUN = {"output", "resume", "config", "watch"}  # Not taken from a configuration.
TRAIN_LEVELS = {"easy": 200, "hard": 500}  # As in the paper.


def run_parser(program: str, description: str) -> argparse.ArgumentParser:
    """Returns a parser of these options."""
    parser = argparse.ArgumentParser(
        prog=f"python3 -m learners.{program}",
        description=description,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    what = parser.add_argument_group("training").add_argument
    what("--game", default="coinrun", choices=ENV_NAMES, metavar="GAME")
    what("--mode", default="easy", help="distribution mode; default: %(default)s")
    what("--levels", type=int, help="train on levels 0 ...; 0: all; default: 200 easy, 500 hard")
    what("--start-level", type=int, default=0, help="the first level seed; default: %(default)s")
    what("--sequential-levels", action="store_true", help="play the levels in order")
    what("--network", default="impala", choices=NETWORKS)
    what("--width", type=int, default=1, help="factor of its channels: 1, 2 or 4 in the paper")
    what("--init", default="glorot", choices=INITS, help="weights of IMPALA; default: %(default)s")
    what("--seed", type=int, default=0)
    what("--num-envs", type=int, default=64, help="of each rank; default: %(default)s")
    run = parser.add_argument_group("the run").add_argument
    run("--config", metavar="FILE", help="JSON of options, such as a run.json; others override it")
    run("--wandb", metavar="PROJECT", help="report to Weights & Biases, if it is installed")
    run("--total-steps", type=int, help="default: 25M in easy mode, 200M in others")
    run("--output", default="run", metavar="DIR", help="default: %(default)s")
    run("--resume", action="store_true", help="continue from the checkpoint in DIR, if any")
    run("--checkpoint-interval", type=float, default=300, help="in seconds; default: %(default)s")
    run("--time-limit", type=float, help="in seconds; then save and stop")
    run("--server", help="its address, or several; default: in this process")
    run("--watch", metavar="HOST:PORT", help="step on a server of its own, with pages there")
    run("--server-timeout", type=float, default=600, help="wait for a stopped server; in seconds")
    speed = parser.add_argument_group("speed").add_argument
    speed("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    cores = len(os.sched_getaffinity(0))
    speed("--threads", type=int, default=cores, help="on a CPU; default: %(default)s")
    speed("--precision", choices=("float32", "bfloat16"), help="default: the device's faster one")
    speed("--eager", action="store_true", help="on a GPU, PyTorch's layers without graphs: slow")
    speed("--compile", action=argparse.BooleanOptionalAction, default=True, help="on a GPU only")
    return parser


def words_of(options: Mapping[str, Any]) -> list[str]:
    """Returns options as arguments of a command line; those that are None are omitted."""
    words = []
    for name, value in options.items():
        option = name.replace("_", "-")
        if value is True or (value is False and name == "compile"):
            words.append(f"--{option}" if value else f"--no-{option}")
        elif value is not None and value is not False:
            words += [f"--{option}", str(value)]
    return words


def parsed(
    parser: argparse.ArgumentParser, arguments: Sequence[str] | None
) -> argparse.Namespace:
    """Returns the options: of the arguments, then of --config, then the defaults."""
    arguments = sys.argv[1:] if arguments is None else arguments
    options = parser.parse_args(arguments)
    if options.config:
        try:
            values = json.loads(Path(options.config).read_text())
            values = dict(values.get("options", values))  # Of a run.json.
        except (OSError, ValueError, AttributeError, TypeError) as error:
            parser.error(f"--config {options.config} is not a JSON object of options: {error}")
        words = words_of({k: v for k, v in values.items() if k not in _OF_ONE_RUN})
        options = parser.parse_args([*words, *arguments])
    return _completed(options)


def _completed(options: argparse.Namespace) -> argparse.Namespace:
    """Fills in the defaults that depend on other options, and returns the same object."""
    if options.num_envs < 2:
        raise SystemExit("--num-envs is at least 2: the environments are stepped in two halves")
    if options.levels is None:
        options.levels = TRAIN_LEVELS.get(options.mode, 0)
    if options.total_steps is None:
        options.total_steps = 25_000_000 if options.mode == "easy" else 200_000_000
    if options.eager:
        options.compile = False
    if options.precision is None:
        precision = default_precision(torch.device(options.device))
        options.precision = str(precision).removeprefix("torch.")
    return options


def set_device(options: argparse.Namespace) -> torch.device:
    """Returns the device, and makes it the current one: of several GPUs, the rank's."""
    device = torch.device(options.device)
    if device.type == "cuda":
        if device.index is None:
            device = torch.device("cuda", int(os.environ.get("LOCAL_RANK", 0)))
        torch.cuda.set_device(device)
        torch.backends.cudnn.benchmark = True
        networks.is_eager = options.eager
    else:
        cpu.use_one_thread()
        cpu.keep_freed_memory()
    return device
