"""Servers on separate hosts: under every fault the learner's trace equals an undisturbed one."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from faults import KINDS, SILENT_KINDS, Fault, FaultDriver, play
from learner_process import LearnerError
from learner_script import Script
from learner_trace import FIELDS, Trace, difference
from testbed import LEARNER, SERVERS, TIMEOUT_S, Testbed, assert_same

MakeTestbed = Callable[..., Testbed]
# A silent server is given up after some 2 s; the machine may be busy.
_GIVEN_UP_S = 6.0


@pytest.mark.parametrize("kind", KINDS)
def test_the_slice_of_a_lost_server_continues_on_another(
    make_testbed: MakeTestbed, script: Script, expected: Trace, kind: str
) -> None:
    testbed = make_testbed()
    lost = Fault(script.request_count // 4, "a", kind, 2 * _GIVEN_UP_S)
    trace = play(testbed, script, [lost])
    assert_same(expected, trace, testbed.servers)
    assert max(map(testbed.servers.most_pools, SERVERS[1:])) > 1, "one has the slice, too"
    assert trace.durations.max() < _GIVEN_UP_S


def test_servers_are_killed_one_after_another(
    make_testbed: MakeTestbed, script: Script, expected: Trace
) -> None:
    testbed = make_testbed()
    kills = [
        Fault(script.request_count * (i + 1) // 7, SERVERS[i % 3], "kill", 0.5) for i in range(6)
    ]
    assert_same(expected, play(testbed, script, kills), testbed.servers)
    assert max(map(testbed.servers.most_pools, SERVERS)) > 1


@pytest.mark.parametrize("returning", [("b",), SERVERS], ids=["one", "all"])
def test_all_servers_are_killed_and_some_return(
    make_testbed: MakeTestbed,
    script: Script,
    expected: Trace,
    returning: tuple[str, ...],
) -> None:
    testbed = make_testbed()
    kills = [
        Fault(script.request_count // 4, host, "kill", 1.0 if host in returning else math.inf)
        for host in SERVERS
    ]
    assert_same(expected, play(testbed, script, kills), testbed.servers)


@pytest.mark.parametrize("kind", KINDS)
def test_a_single_server_returns(
    make_testbed: MakeTestbed, script: Script, expected: Trace, kind: str
) -> None:
    testbed = make_testbed(SERVERS[:1])
    faults = [Fault(script.request_count * part // 4, "a", kind, 2.0) for part in (1, 3)]
    assert_same(expected, play(testbed, script, faults), testbed.servers)


@pytest.mark.parametrize("kind", SILENT_KINDS)
@pytest.mark.parametrize("hosts", [SERVERS, SERVERS[:1]], ids=["three", "one"])
def test_the_learner_is_silent_for_some_time(
    make_testbed: MakeTestbed, script: Script, expected: Trace, hosts: tuple[str, ...], kind: str
) -> None:
    testbed = make_testbed(hosts)
    faults = [Fault(script.request_count // 4, LEARNER, kind, 4.0)]
    assert_same(expected, play(testbed, script, faults), testbed.servers)


@pytest.mark.parametrize("hosts", [SERVERS, SERVERS[:1]], ids=["three", "one"])
@pytest.mark.parametrize("kind", ["kill", "cut both"])
def test_a_learner_without_servers_gets_an_error(
    make_testbed: MakeTestbed, hosts: tuple[str, ...], kind: str
) -> None:
    script = Script(request_count=1_000_000)
    testbed = make_testbed(hosts)
    learner = testbed.learner(script, announce=(300,), reconnect_timeout=3.0)
    FaultDriver(testbed, learner).run([Fault(300, host, kind, math.inf) for host in hosts])
    message = "UnavailableError: .*the connection broke and could not be made again within 3s: "
    with pytest.raises(LearnerError, match=message):
        learner.trace(TIMEOUT_S)


def test_a_trace_with_one_different_response_is_detected() -> None:
    digests = np.arange(5 * len(FIELDS), dtype=np.uint32).reshape(5, -1)
    expected = Trace(digests, np.zeros(5))
    assert difference(expected, Trace(digests.copy(), np.ones(5))) is None
    wrong = digests.copy()
    wrong[3, FIELDS.index("rewards")] += 1
    found = difference(expected, Trace(wrong, np.zeros(5)))
    assert found == "the response to request 3 differs in rewards; so do 0 more"
    assert difference(expected, Trace(digests[:4], np.zeros(4))) == "4 responses instead of 5"
