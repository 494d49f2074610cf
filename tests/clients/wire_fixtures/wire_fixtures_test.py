"""The wire fixtures equal a current server's messages; their check detects other requests."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

_FOLDER = Path(__file__).resolve().parents[3] / "clients/wire_fixtures"
sys.path.append(str(_FOLDER))

from record import record  # noqa: E402
from script import ENCODINGS, EXPECTED, create_pool_request, expected_values  # noqa: E402
from script import requests, response_paths, values_of  # noqa: E402

from procgen_client import Client, Pool, Reset, ServerProcess, errors  # noqa: E402
from procgen_client._proto import pools_pb2, step_pb2  # noqa: E402
from procgen_client._transport import is_native  # noqa: E402
from procgen_client.options import LevelSampler  # noqa: E402


def test_the_current_server_sends_the_fixtures(tmp_path: Path) -> None:
    with ServerProcess(flags=["--workers=1"]) as server:
        record(server.address, tmp_path)
    recorded = {path.relative_to(_FOLDER) for path in _FOLDER.glob("*/*.bin")}
    assert recorded == {path.relative_to(tmp_path) for path in tmp_path.glob("*/*.bin")}
    for path in [*recorded, EXPECTED]:
        same = (tmp_path / path).read_bytes() == (_FOLDER / path).read_bytes()
        assert same, f"{path} differs: update it with clients/wire_fixtures/record.py"


def test_the_fixtures_contain_the_expected_messages() -> None:
    answers = [
        [step_pb2.StepPoolResponse.FromString(path.read_bytes()) for path in paths]
        for paths in (response_paths("raw", number) for number in range(len(requests())))
    ]
    assert list(expected_values(answers)) == json.loads((_FOLDER / EXPECTED).read_text())
    assert max(map(len, answers)) > 1


@contextmanager
def _checked(encoding: str, status: int) -> Iterator[str]:
    command = [sys.executable, _FOLDER / "check.py", encoding]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        yield process.stdout.readline().removeprefix("listening on ").strip()
        said, _ = process.communicate()
        assert process.returncode == status, said


def _pool(client: Client, encoding: str) -> Pool:
    spec = create_pool_request(encoding).spec
    spec.transport = pools_pb2.TRANSPORT_STREAM
    return client.create_pool_from_spec(spec, pool_id="recorded")


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_the_client_sends_the_recorded_requests(encoding: str) -> None:
    if encoding != "raw" and not is_native():
        pytest.skip("the native module is missing")
    expected = json.loads((_FOLDER / EXPECTED).read_text())
    with _checked(encoding, 0) as address, Client(address) as client:
        pool = _pool(client, encoding)
        batches = [
            pool.observe(),
            pool.step([4, 7]),
            pool.step([-1, 3], final_observations=True),
            pool.step([8], first_env=1, repeat_count=3, next_levels={1: 42}),
            pool.step([4, 4], observe=False, resets=[1]),
            pool.reset([Reset(0, level_seed=7, rand_seed=9)]),
            pool.set_level_sampler(LevelSampler([3, 5], [1, 2], 1)),
            pool.reset(),
            pool.step([2, 6]),
        ]
        pool.close()
    for batch, values in zip(batches, expected[1:], strict=True):
        assert values == (None if batch is None else values_of(batch))


def test_a_different_request_is_reported() -> None:
    with _checked("raw", 1) as address, Client(address) as client:
        pool = _pool(client, "raw")
        pool.observe()
        with pytest.raises(errors.FailedPreconditionError, match="(?s)request 2.*actions: 5"):
            pool.step([5, 7])


def test_an_incomplete_session_is_reported() -> None:
    with _checked("raw", 1) as address, Client(address) as client:
        _pool(client, "raw").observe()
