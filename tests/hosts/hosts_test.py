"""A fleet on hosts of its own: whatever happens to them, the learner sees what one server shows."""

from __future__ import annotations

import pytest
from fleet import FLEET
from learner_script import Script
from learner_trace import Trace
from network import Direction
from stage import NODES, SPARE, Stage, assert_same

# A node whose shards were taken away need not wait for its --drain_timeout, which is 30 s.
_DRAIN_S = 15.0


@pytest.mark.peers
def test_a_node_is_killed(stage: Stage, script: Script, expected: Trace) -> None:
    trace = stage.play(script, {script.request_count // 4: lambda: stage.fleet.kill("a")})
    assert_same(expected, trace, stage.fleet)
    stage.fleet.await_log("shard_lost .*node=a")


@pytest.mark.parametrize("direction", ["both", "to", "from"])
def test_packets_of_a_node_are_dropped(
    stage: Stage, script: Script, expected: Trace, direction: Direction
) -> None:
    trace = stage.play(
        script,
        {
            script.request_count // 4: lambda: stage.network.cut("a", direction),
            script.request_count // 2: lambda: stage.network.heal("a"),
        },
    )
    assert_same(expected, trace, stage.fleet)
    stage.fleet.await_log("shard_lost .*node=a")
    stage.fleet.await_log("pool_deleted", host="a")  # What it had when it was cut off.


@pytest.mark.peers
def test_a_node_is_unplugged(stage: Stage, script: Script, expected: Trace) -> None:
    trace = stage.play(
        script,
        {
            script.request_count // 4: lambda: stage.network.unplug("b"),
            script.request_count // 2: lambda: stage.network.plug("b"),
        },
    )
    assert_same(expected, trace, stage.fleet)
    stage.fleet.await_log("shard_lost .*node=b")
    stage.fleet.await_log("pool_deleted", host="b")


def test_a_node_pauses(stage: Stage, script: Script, expected: Trace) -> None:
    trace = stage.play(
        script,
        {
            script.request_count // 4: lambda: stage.fleet.pause("c"),
            script.request_count // 2: lambda: stage.fleet.resume("c"),
        },
    )
    assert_same(expected, trace, stage.fleet)
    stage.fleet.await_log("shard_lost .*node=c")
    stage.fleet.await_log("pool_deleted", host="c")


def test_a_node_drains(stage: Stage, script: Script, expected: Trace) -> None:
    trace = stage.play(script, {script.request_count // 4: lambda: stage.fleet.drain("b")})
    assert_same(expected, trace, stage.fleet)
    assert stage.fleet.await_exit("b", _DRAIN_S) == 0


def test_a_node_is_added(stage: Stage, script: Script, expected: Trace) -> None:
    trace = stage.play(
        script,
        {script.request_count // 4: lambda: stage.fleet.start(SPARE)},
        {script.request_count // 2: lambda: stage.fleet.await_log(f"shard_placed .*node={SPARE}")},
    )
    assert_same(expected, trace, stage.fleet)


def test_all_nodes_are_killed_and_one_comes(
    stage: Stage, script: Script, expected: Trace
) -> None:
    def kill_all() -> None:
        for host in NODES:
            stage.fleet.kill(host)
        stage.fleet.start(NODES[0])

    trace = stage.play(script, {script.request_count // 4: kill_all})
    assert_same(expected, trace, stage.fleet)


@pytest.mark.parametrize("direction", ["both", "to", "from"])
def test_packets_of_the_fleet_server_are_dropped(
    stage: Stage, script: Script, expected: Trace, direction: Direction
) -> None:
    def cut_for_long() -> None:
        stage.network.cut(FLEET, direction)
        stage.fleet.await_log("shard_lost")
        stage.network.heal(FLEET)

    trace = stage.play(script, {script.request_count // 4: cut_for_long})
    assert_same(expected, trace, stage.fleet)


def test_the_fleet_server_is_killed_and_started_again(
    stage: Stage, script: Script, expected: Trace
) -> None:
    def start_again() -> None:
        stage.fleet.kill(FLEET)
        stage.fleet.start(FLEET)

    trace = stage.play(
        script, {script.request_count // 4: start_again, script.request_count // 2: start_again}
    )
    assert_same(expected, trace, stage.fleet)
    assert stage.fleet.log().count("event=pool_resumed") == 2


def test_the_fleet_server_is_started_again_while_a_node_is_killed(
    stage: Stage, script: Script, expected: Trace
) -> None:
    def kill_both() -> None:
        stage.fleet.kill(FLEET)
        stage.fleet.kill("a")
        stage.fleet.start(FLEET)

    trace = stage.play(script, {script.request_count // 4: kill_both})
    assert_same(expected, trace, stage.fleet)
