"""Double-buffered sampling: half of a pool is stepped while the policy acts on the other."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from procgen_client._out import writable_view
from procgen_client.batch import Batch
from procgen_client.errors import FailedPreconditionError, InvalidArgumentError, ProcgenError
from procgen_client.pool import Pool


class DoubleBufferedSampler:
    """Steps a pool in two halves, alternately, so that neither environments nor policy wait.

    As rlpyt's AlternatingSampler and Sample Factory's double-buffered sampling. Each environment
    gets the batches that it gets from steps of the whole pool::

        sampler = DoubleBufferedSampler(pool)
        for t, rows, batch in sampler.rollout(256):
            if t < 256:
                sampler.send(policy(batch.observations))

    Threads: one at a time; in the process, one may send while another waits for the next half.

    Attributes:
        pool: The pool.
        halves: The environments of each half, as slices.
    """

    def __init__(self, pool: Pool) -> None:
        """Takes a pool; sends nothing.

        Raises:
            InvalidArgumentError: The pool has one environment.
        """
        if pool.env_count < 2:
            raise InvalidArgumentError(
                f"{pool!r} has 1 environment; a pool in two halves has at least 2"
            )
        middle = pool.env_count // 2
        self.pool = pool
        self.halves = (slice(0, middle), slice(middle, pool.env_count))
        # Halves that were yielded and not sent, with the memory of their next observations.
        self._waiting: deque[tuple[slice, Any]] = deque()

    def rollout(
        self,
        step_count: int | None = None,
        *,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> Iterator[tuple[int, slice, Batch]]:
        """Yields (t, rows, batch) of the first half, then of the second, for t = 0, 1, 2, ...

        The batch of t = 0 is the current state, without a step; its rewards and ends repeat those
        of the last step. Call :meth:`send` with the actions of each yielded half, before its next
        turn, except for t = step_count, the last: then no request is in flight, and the pool can
        be saved.

        Leaving the loop early discards the answers in flight; their steps were taken.

        Args:
            step_count: Steps of each environment, T. None: endless.
            out: Receives the observations, as Pool.step's. [T + 1, N, *F]: a rollout buffer; or
                [N, *F]: the latest observations.

        Raises:
            InvalidArgumentError: An argument is out of range. Nothing was sent.
            FailedPreconditionError: On iteration: send was not called; or requests of the pool are
                unanswered.
            ProcgenError: On iteration, any error of the server.
        """
        if step_count is not None and step_count < 0:
            raise InvalidArgumentError(f"step_count is {step_count}; it is at least 0")
        shape = (self.pool.env_count, *self.pool.observation_shape)
        is_buffer = step_count is not None and np.ndim(out) == len(shape) + 1
        if out is not None:
            writable_view(out, ((step_count or 0) + 1, *shape) if is_buffer else shape)
        return self._rollout(step_count, out, is_buffer)

    def send(
        self,
        actions: npt.ArrayLike,
        rows: slice | None = None,
        *,
        annotations: Mapping[str, npt.ArrayLike] | None = None,
    ) -> None:
        """Sends a step of a half.

        While a GPU computes the actions of one half, the other can be received. The half that was
        yielded first is sent first.

        Args:
            actions: int [rows of the half], each in [-1, 15).
            rows: The half. None: the one that was yielded last.
            annotations: As Pool.step's, [rows of the half] or [rows of the half, k].

        Raises:
            InvalidArgumentError: A wrong length, or a value out of range. Nothing was sent.
            FailedPreconditionError: The half does not wait for actions, or the other one is first.
        """
        if not self._waiting:
            raise FailedPreconditionError("no half waits for actions: take one from a rollout")
        rows = self._waiting[-1][0] if rows is None else rows
        first, out = self._waiting[0]
        if rows != first:
            raise FailedPreconditionError(
                f"environments {_text(first)} are the first that wait for actions, not "
                f"environments {_text(rows)}"
            )
        count = rows.stop - rows.start
        self.pool.send_step(
            actions, first_env=rows.start, env_count=count, annotations=annotations, out=out
        )
        self._waiting.popleft()

    def _rollout(
        self, step_count: int | None, out: Any, is_buffer: bool  # noqa: ANN401
    ) -> Iterator[tuple[int, slice, Batch]]:
        self.pool._require_nothing_in_flight()

        def memory(t: int, rows: slice) -> Any:  # noqa: ANN401
            if out is None:
                return None
            return out[t, rows] if is_buffer else out[rows]

        try:
            for rows in self.halves:
                count = rows.stop - rows.start
                self.pool.send_observe(first_env=rows.start, env_count=count, out=memory(0, rows))
            for t in itertools.count() if step_count is None else range(step_count + 1):
                for rows in self.halves:
                    # A copy: another thread may send meanwhile.
                    if any(rows == waiting for waiting, _ in tuple(self._waiting)):
                        raise FailedPreconditionError(
                            f"the actions of environments {_text(rows)} were not sent: call send "
                            "before the next turn of a half"
                        )
                    batch = self.pool.receive()
                    if t != step_count:
                        self._waiting.append((rows, memory(t + 1, rows)))
                    yield t, rows, batch
        finally:
            self._waiting.clear()
            self._discard()

    def _discard(self) -> None:
        try:
            while self.pool.in_flight:
                self.pool.receive()
        except ProcgenError:
            pass  # The stream has ended.


def _text(rows: slice) -> str:
    return f"{rows.start} ... {rows.stop - 1}"
