"""Connecting; the catalog, nodes and pools of a server."""

from __future__ import annotations

import gc
import socket
import time

import pytest

from procgen_client import Client, Pool, ServerProcess, catalog, connect, errors
from procgen_client._proto import pools_pb2


def test_engine_in_this_process_has_the_same_catalog(client: Client) -> None:
    served, local = client.catalog(), catalog()
    assert [action["name"] for action in local["actions"]] == [each.name for each in served.actions]
    assert [game["name"] for game in local["games"]] == [game.name for game in served.games]
    for game, of_server in zip(local["games"], served.games, strict=True):
        limits = {
            pools_pb2.DistributionMode.Name(mode.distribution_mode).lower(): mode.time_limit_steps
            for mode in of_server.modes
        }
        assert {
            f"distribution_mode_{name}": mode["time_limit_steps"]
            for name, mode in game["modes"].items()
        } == limits


def test_load_counts_pools_and_environments(client: Client) -> None:
    before = client.load()
    with client.create_pool("maze", 3):
        during = client.load()
    after = client.load()
    assert during.pool_count - before.pool_count == 1
    assert during.env_count - before.env_count == 3
    assert (after.pool_count, after.env_count) == (
        before.pool_count,
        before.env_count,
    )


def test_server_without_a_cluster_lists_itself(client: Client) -> None:
    listed = client.list_nodes()
    assert listed.cluster == ""
    assert [node.name for node in listed.nodes] == [listed.local_node]
    assert listed.nodes[0].address == client.address
    assert listed.nodes[0].healthy


def test_unresolvable_address_is_unavailable() -> None:
    with pytest.raises(errors.UnavailableError, match="no server answers at nowhere.invalid:1"):
        connect("nowhere.invalid:1", timeout=0.3)


def test_connect_to_a_silent_server_times_out() -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        begun = time.monotonic()
        with pytest.raises(errors.UnavailableError, match=r"within (300ms|0.3 s): "):
            connect(f"127.0.0.1:{silent.getsockname()[1]}", timeout=0.3)
        assert time.monotonic() - begun < 10


def test_closed_client_rejects_calls(server: ServerProcess) -> None:
    client = connect(server.address)
    client.close()
    client.close()
    assert client.closed
    with pytest.raises(errors.CancelledError, match="closed by this client"):
        client.load()


def test_server_has_the_pool_that_was_asked_for(client: Client) -> None:
    with client.create_pool(
        ["maze", "coinrun"], 4, num_levels=7, pool_id="mine", autoreset_mode="disabled",
        name="Münze", labels={"seed": "3", "run/1": "a=b"},
    ) as pool:  # fmt: skip
        assert pool.name == "pools/mine"
        (message,) = (each for each in client.list_pools() if each.name == pool.name)
        assert message.spec == client.get_pool(pool.name).spec
        spec = message.spec
        assert (list(spec.games), spec.env_count) == (["maze", "coinrun"], 4)
        assert spec.autoreset_mode == pools_pb2.AUTORESET_MODE_DISABLED
        assert spec.options.num_levels == 7
        assert spec.display_name == "Münze"
        assert dict(spec.labels) == {"seed": "3", "run/1": "a=b"}
        assert spec.options.center_agent
        assert spec.options.distribution_mode == pools_pb2.DISTRIBUTION_MODE_HARD
        assert spec.options.rand_seed == pool.options["rand_seed"]


def test_leaving_the_context_of_a_pool_deletes_it(client: Client) -> None:
    with client.create_pool("maze", 1) as pool:
        assert client.get_pool(pool.name).spec.env_count == 1
    with pytest.raises(errors.NotFoundError):
        client.get_pool(pool.name)
    with pytest.raises(errors.InvalidArgumentError, match="pools/"):
        client.get_pool("no name")


def test_forgotten_pool_is_deleted(client: Client) -> None:
    name = client.create_pool("maze", 1).name
    gc.collect()
    with pytest.raises(errors.NotFoundError):
        client.get_pool(name)


@pytest.mark.parametrize(
    ("arguments", "options", "error", "message"),
    [
        (("maze", 1), {"pool_id": "No Good"}, errors.InvalidArgumentError, "pool_id"),
        (("maze", 1), {"name": "x" * 129}, errors.InvalidArgumentError, "of 129 bytes"),
        (("maze", 1), {"name": 3}, errors.InvalidArgumentError, "name is 3; it is text"),
        (("maze", 1), {"labels": {"a b": ""}}, errors.InvalidArgumentError, "has the key 'a b'"),
        (("maze", 1), {"labels": {"a=b": ""}}, errors.InvalidArgumentError, "keys have no '='"),
        (("maze", 1), {"labels": ["a"]}, errors.InvalidArgumentError, "maps text to text"),
        (("maze", 10**6), {}, errors.ResourceExhaustedError, "env_count_max"),
    ],
)
def test_invalid_pool_is_rejected_with_a_reason(
    client: Client,
    arguments: tuple[str, int],
    options: dict[str, object],
    error: type[errors.ProcgenError],
    message: str,
) -> None:
    with pytest.raises(error, match=message):
        client.create_pool(*arguments, **options)


def test_name_in_use_is_rejected(client: Client) -> None:
    with client.create_pool("maze", 1, pool_id="taken"):
        with pytest.raises(errors.AlreadyExistsError, match="taken"):
            client.create_pool("maze", 1, pool_id="taken")


def test_failed_server_start_is_reported() -> None:
    with pytest.raises(errors.UnavailableError, match="ended with status"):
        ServerProcess(None, ["--no-such-flag"])


def test_missing_server_binary_is_not_found() -> None:
    with pytest.raises(FileNotFoundError, match="no-such-server"):
        ServerProcess("no-such-server")


def test_pool_may_be_closed_after_its_client(server: ServerProcess) -> None:
    client = connect(server.address)
    pool = client.create_pool("maze", 2)
    pool.observe()
    client.close()
    pool.close()
    assert pool.closed


def test_server_without_room_says_so_and_leaves_no_connection(client: Client) -> None:
    before = client.load()
    for _ in range(3):
        with pytest.raises(errors.ResourceExhaustedError, match="limit"):
            Pool("maze", 10**6, server=client.address)
    assert client.load().pool_count == before.pool_count
