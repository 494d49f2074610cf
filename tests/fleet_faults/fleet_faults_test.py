"""A fleet on separate hosts: under every fault the learner's trace equals that of one server."""

from __future__ import annotations

import pytest
from fleet import FLEET
from learner_script import Script
from learner_trace import Trace
from network import Direction
from testbed import NODES, SPARE, Testbed, assert_same

# A node without shards need not wait for its --drain_timeout of 30 s.
_DRAIN_S = 15.0


@pytest.mark.peers
def test_a_node_is_killed(testbed: Testbed, script: Script, expected: Trace) -> None:
    trace = testbed.play(script, {script.request_count // 4: lambda: testbed.fleet.kill("a")})
    assert_same(expected, trace, testbed.fleet)
    testbed.fleet.await_log("shard_lost .*node=a")


@pytest.mark.parametrize("direction", ["both", "to", "from"])
def test_packets_of_a_node_are_dropped(
    testbed: Testbed, script: Script, expected: Trace, direction: Direction
) -> None:
    trace = testbed.play(
        script,
        {
            script.request_count // 4: lambda: testbed.network.cut("a", direction),
            script.request_count // 2: lambda: testbed.network.heal("a"),
        },
    )
    assert_same(expected, trace, testbed.fleet)
    testbed.fleet.await_log("shard_lost .*node=a")
    testbed.fleet.await_log("pool_deleted", host="a")  # Its shard from before the cut.


@pytest.mark.peers
def test_a_node_is_unplugged(testbed: Testbed, script: Script, expected: Trace) -> None:
    trace = testbed.play(
        script,
        {
            script.request_count // 4: lambda: testbed.network.unplug("b"),
            script.request_count // 2: lambda: testbed.network.plug("b"),
        },
    )
    assert_same(expected, trace, testbed.fleet)
    testbed.fleet.await_log("shard_lost .*node=b")
    testbed.fleet.await_log("pool_deleted", host="b")


def test_a_node_pauses(testbed: Testbed, script: Script, expected: Trace) -> None:
    trace = testbed.play(
        script,
        {
            script.request_count // 4: lambda: testbed.fleet.pause("c"),
            script.request_count // 2: lambda: testbed.fleet.resume("c"),
        },
    )
    assert_same(expected, trace, testbed.fleet)
    testbed.fleet.await_log("shard_lost .*node=c")
    testbed.fleet.await_log("pool_deleted", host="c")


def test_a_node_drains(testbed: Testbed, script: Script, expected: Trace) -> None:
    trace = testbed.play(script, {script.request_count // 4: lambda: testbed.fleet.drain("b")})
    assert_same(expected, trace, testbed.fleet)
    assert testbed.fleet.await_exit("b", _DRAIN_S) == 0


def test_a_node_is_added(testbed: Testbed, script: Script, expected: Trace) -> None:
    placed = f"shard_placed .*node={SPARE}"
    trace = testbed.play(
        script,
        {script.request_count // 4: lambda: testbed.fleet.start(SPARE)},
        {script.request_count // 2: lambda: testbed.fleet.await_log(placed)},
    )
    assert_same(expected, trace, testbed.fleet)


def test_all_nodes_are_killed_and_one_joins(
    testbed: Testbed, script: Script, expected: Trace
) -> None:
    def kill_all() -> None:
        for host in NODES:
            testbed.fleet.kill(host)
        testbed.fleet.start(NODES[0])

    trace = testbed.play(script, {script.request_count // 4: kill_all})
    assert_same(expected, trace, testbed.fleet)


@pytest.mark.parametrize("direction", ["both", "to", "from"])
def test_packets_of_the_fleet_server_are_dropped(
    testbed: Testbed, script: Script, expected: Trace, direction: Direction
) -> None:
    def cut_for_long() -> None:
        testbed.network.cut(FLEET, direction)
        testbed.fleet.await_log("shard_lost")
        testbed.network.heal(FLEET)

    trace = testbed.play(script, {script.request_count // 4: cut_for_long})
    assert_same(expected, trace, testbed.fleet)


def test_the_fleet_server_is_killed_and_started_again(
    testbed: Testbed, script: Script, expected: Trace
) -> None:
    def start_again() -> None:
        testbed.fleet.kill(FLEET)
        testbed.fleet.start(FLEET)

    trace = testbed.play(
        script, {script.request_count // 4: start_again, script.request_count // 2: start_again}
    )
    assert_same(expected, trace, testbed.fleet)
    assert testbed.fleet.log().count("event=pool_resumed") == 2


def test_the_fleet_server_is_started_again_while_a_node_is_killed(
    testbed: Testbed, script: Script, expected: Trace
) -> None:
    def kill_both() -> None:
        testbed.fleet.kill(FLEET)
        testbed.fleet.kill("a")
        testbed.fleet.start(FLEET)

    trace = testbed.play(script, {script.request_count // 4: kill_both})
    assert_same(expected, trace, testbed.fleet)
