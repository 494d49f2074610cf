"""A pool as a Gymnasium vector environment."""

from __future__ import annotations

import weakref
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from procgen_client._requests import ACTION_COUNT, Reset, in_range
from procgen_client.batch import Batch
from procgen_client.client import Client
from procgen_client.envs._gymnasium import (
    AutoresetMode,
    VectorEnv,
    vector_spaces,
    warn_of_old_gymnasium,
)
from procgen_client.envs._infos import episode_infos, level_infos, reset_infos
from procgen_client.errors import (
    FailedPreconditionError,
    InvalidArgumentError,
    UnimplementedError,
)
from procgen_client.pool import Pool
from procgen_client.tools.local_server import is_local, open_client

_AUTORESET_MODES = {
    AutoresetMode.NEXT_STEP: "next_step",
    AutoresetMode.SAME_STEP: "same_step",
    AutoresetMode.DISABLED: "disabled",
}


class ProcgenVectorEnv(VectorEnv):
    """N environments on a server, with the contract of Gymnasium's VectorEnv (1.1 and later).

    It subclasses gymnasium.vector.VectorEnv where Gymnasium 1.0 or later is installed. Where an
    older one is, whose vector environments have another contract, it only has the spaces of
    Gymnasium, and making it warns. Without Gymnasium the spaces are small classes with the same
    names and attributes. ``metadata["autoreset_mode"]`` is a member of an enumeration with
    Gymnasium's names and values, Gymnasium's own since 1.1.

    Shapes (N = num_envs): observations uint8 [N, 64, 64, 3], red, green, blue, top row first;
    actions int [N], each in [0, 15) (-1, which is outside of the action space, does nothing and
    ends the episode); rewards float64 [N]; terminations and truncations bool [N]. A time limit
    truncates, everything else terminates.

    Observations of another form (screen_size, grayscale_obs, layout and frame_stack, as
    Client.create_pool takes them) are [N, *pool.observation_shape]. A stack of frames has its own
    axis before the frame's, as Gymnasium's FrameStackObservation makes it; at an episode's
    beginning, and after restore_states and clone_states, one frame stands in all places.

    Infos, each with a mask ``_key`` of the environments it holds for:

    - ``level_seed`` int32 [N]: level in the observation;
    - ``prev_level_seed`` int32 [N]: level that was stepped; ``prev_level_complete`` bool [N]: this
      step completed it;
    - ``episode_return`` float32 [N], ``episode_length`` int32 [N]: of episodes that ended in this
      step (not called ``episode``, a key that Gymnasium's RecordEpisodeStatistics writes);
    - with SAME_STEP, where an episode ended: ``final_obs`` (array of objects: its last observation,
      or None) and ``final_info`` (dict: its last ``level_seed``, ``prev_level_seed``,
      ``prev_level_complete``, and ``episode_return``, ``episode_length``, with masks).

    Threads: one at a time.

    Attributes:
        num_envs: Number of environments, N.
        pool: The pool on the server, for what the vector environment has no name for.
    """

    metadata: dict[str, Any] = {
        "render_modes": ["rgb_array"],
        "render_fps": 15,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    # Whether it may be given to what takes Gymnasium's vector environments.
    _is_for_gymnasium = True

    def __init__(
        self,
        games: str | Sequence[str],
        num_envs: int = 64,
        *,
        server: str | Client | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        render_size_px: int = 512,
        copy: bool = True,
        frame_skip: int = 1,
        **options: Any,
    ) -> None:
        """Makes the pool.

        Args:
            games, num_envs: A game, or several that are dealt in turn to N environments.
            server: Address of a server, or a Client (which stays open on close). None: the address
                in the variable PROCGEN_SERVER, else a local server, which is started and shares
                memory.
            autoreset_mode: What follows the step that ends an episode: a member of AutoresetMode or
                its value.
            render_mode: "rgb_array" for render(), or None.
            render_size_px: Side of render's square pictures, in pixels.
            copy: True: observations are arrays of your own. So they are without a copy, unless they
                are shared. False: with transport "shared_memory" they are read-only views of
                memory that the server draws into, and only so many may be kept
                (held_batches_max, 2 by default, and those of this step). It saves 12 kB of
                copying for each environment.
            frame_skip: Each action is taken so many times, in [1, 1000], and only the last is
                drawn; rewards are summed, and an environment stops when its episode ends.
            **options: As Client.create_pool takes them: the options of Procgen 0.10.7
                (distribution_mode, num_levels, start_level, rand_seed, use_sequential_levels, ...),
                the form of the observations (screen_size, grayscale_obs, layout, frame_stack) and
                how they travel (encoding, chunk_count, transport).

        Raises:
            InvalidArgumentError: An argument is out of range.
            UnimplementedError: The server does not draw for people, with render_mode "rgb_array".
            ProcgenError: As Client and Client.create_pool.
        """
        if self._is_for_gymnasium:
            warn_of_old_gymnasium()
        mode = _autoreset_mode(autoreset_mode)
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InvalidArgumentError(f"render_mode is {render_mode!r}; it is None or 'rgb_array'")
        in_range("frame_skip", frame_skip, 1, 1000)
        client = open_client(server)
        is_drawn = render_mode is not None
        try:
            self.pool = _create_pool(client, games, num_envs, mode, options, is_drawn=is_drawn)
        except BaseException:
            if client is not server:
                client.close()
            raise
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.metadata = self.metadata | {"autoreset_mode": mode}
        self.__dict__ |= vector_spaces(self.pool.observation_shape, ACTION_COUNT, num_envs)
        self._mode = mode
        self._frame_skip = frame_skip
        self._next_levels: dict[int, int] = {}  # To be told with the next step.
        self._copy = copy
        self._render_size_px = render_size_px
        self._untouched = True  # Neither reset nor stepped: all stand at their first step.
        self._everywhere = np.ones(num_envs, np.bool_)
        self._ended = np.zeros(num_envs, np.bool_)  # Whose episode is over, to be reset (DISABLED).
        owned = None if client is server else client
        self._close_once = weakref.finalize(self, _close, self.pool, owned)

    def __enter__(self) -> ProcgenVectorEnv:
        """Gives the environment itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Closes the environment."""
        self.close()

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begins new episodes and gives the first observations.

        Args:
            seed: Seeds the environments' choice of levels anew: environment i with seed + i, or
                with seed[i] (None: it goes on as it is). None: all go on; so the very first reset
                gives the episodes that rand_seed began, as in upstream.
            options: ``reset_mask``, bool [N] with at least one True: only these begin anew, and the
                others stay as they are. The dict is left as it is: wrappers read it afterwards.
                ``level_seeds``, int [N]: the levels to play.

        Returns:
            Observations and infos. ``_level_seed`` is the reset_mask; no environment has stepped a
            level, so the masks of ``prev_level_seed`` and ``prev_level_complete`` are false.

        Raises:
            InvalidArgumentError: `seed` has a wrong length, or an option is malformed.
        """
        options = {} if options is None else options
        mask = _reset_mask(options.get("reset_mask"), self.num_envs)
        seeds = _seeds(seed, self.num_envs)
        levels = _level_seeds(options.get("level_seeds"), self.num_envs)
        if self._untouched and mask.all() and seed is None and options.get("level_seeds") is None:
            batch = self.pool.observe()
        else:
            batch = self.pool.reset(
                [Reset(int(i), levels[i], seeds[i]) for i in np.flatnonzero(mask)]
            )
        self._untouched = False
        self._ended[mask] = False
        return self._observations(batch), reset_infos(batch, mask)

    def step(
        self, actions: npt.ArrayLike
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Steps all environments.

        Args:
            actions: int [N], each in [0, 15), or -1.

        Returns:
            Observations, rewards, terminations, truncations, infos.

        Raises:
            InvalidArgumentError: `actions` has a wrong length or a value out of range. Nothing has
                moved.
            FailedPreconditionError: With DISABLED, an environment's episode is over: reset it.
                Nothing has moved. Or step_async was called and step_wait was not.
        """
        self.step_async(actions)
        return self.step_wait()

    def step_async(self, actions: npt.ArrayLike) -> None:
        """Has all environments stepped, and does not wait for it; step_wait gives the results.

        The first half of step, as Gymnasium's AsyncVectorEnv has it: what is done between the two
        halves costs no time. Nothing else may be asked of the environment there.

        Args and errors as step.
        """
        if self.pool.in_flight:
            raise FailedPreconditionError("step_async was called before: call step_wait first")
        if self._mode is AutoresetMode.DISABLED and self._ended.any():
            raise FailedPreconditionError(
                f"the episodes of environments {np.flatnonzero(self._ended).tolist()} are over: "
                'reset them with options={"reset_mask": ...}'
            )
        actions = np.asarray(actions)
        if actions.shape != (self.num_envs,):
            raise InvalidArgumentError(
                f"actions has shape {list(actions.shape)}; it is [{self.num_envs}]"
            )
        self.pool.send_step(
            actions,
            repeat_count=self._frame_skip,
            final_observations=self._mode is AutoresetMode.SAME_STEP,
            next_levels=self._next_levels,
        )
        self._next_levels = {}

    def step_wait(
        self,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Waits for what step_async began, and gives what step gives.

        Raises:
            FailedPreconditionError: step_async was not called.
            ProcgenError: Whatever the server says.
        """
        if not self.pool.in_flight:
            raise FailedPreconditionError("step_async was not called: call it first")
        batch = self.pool.receive()
        self._untouched = False
        self._ended = batch.ended
        infos = level_infos(batch, self._everywhere)
        if np.count_nonzero(self._ended):  # As any(), in a fifth of its time.
            infos |= episode_infos(batch, self._ended, self._mode is AutoresetMode.SAME_STEP)
        return (
            self._observations(batch),
            batch.rewards.astype(np.float64),
            batch.terminated,
            batch.truncated,
            infos,
        )

    def set_next_levels(self, level_seeds: Mapping[int, int]) -> None:
        """Chooses the levels that environments play after their present ones.

        It is told to the server with the next step, and holds until they are played: also from an
        episode that ends with that very step.

        Args:
            level_seeds: Level seeds by environment.

        Raises:
            InvalidArgumentError: There is no such environment.
        """
        for environment in level_seeds:
            in_range("environment", environment, 0, self.num_envs - 1)
        self._next_levels |= level_seeds

    @property
    def episodes_over(self) -> np.ndarray:
        """Whose episode has ended with the last step and no other has begun yet; bool [N]."""
        if self._mode is AutoresetMode.SAME_STEP:
            return np.zeros(self.num_envs, np.bool_)
        return self._ended.copy()

    def save_states(self, environments: Sequence[int] | None = None) -> list[bytes]:
        """Takes snapshots of environments (None: of all); see Pool.save_states."""
        return self.pool.save_states(environments)

    def restore_states(
        self, states: Mapping[int, bytes] | Sequence[bytes]
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Restores saved states and returns observations and infos of all.

        Args:
            states: Snapshots by environment, or a list of one for each; see Pool.restore_states.

        Returns:
            Observations and infos, as of reset.
        """
        self.pool.restore_states(states)
        return self._observe()

    def clone_states(
        self,
        pairs: Iterable[tuple[int, int]],
        *,
        source_pool: Pool | str | None = None,
        source_server: str | None = None,
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Copies states between environments and returns observations and infos of all.

        Args:
            pairs: (source, target) environments; see Pool.clone_states, also for the others. The
                pool of another ProcgenVectorEnv is its attribute ``pool``.
            source_pool: The pool that is read. None: this one.
            source_server: Address of its server. None: the same server.

        Returns:
            Observations and infos, as of reset.
        """
        self.pool.clone_states(pairs, source_pool=source_pool, source_server=source_server)
        return self._observe()

    def render(self) -> tuple[np.ndarray, ...] | None:
        """Draws all environments for people: N pictures, uint8 [side, side, 3].

        None if render_mode is None.
        """
        if self.render_mode is None:
            return None
        return tuple(self.pool.render(size_px=self._render_size_px))

    def close_extras(self, **kwargs: Any) -> None:
        """Deletes the pool, and closes the connection if it was made here; called by close()."""
        if hasattr(self, "_close_once"):  # It is not where __init__ failed.
            self._close_once()

    def _observe(self) -> tuple[np.ndarray, dict[str, Any]]:
        batch = self.pool.observe()
        self._untouched = False
        # One that was saved where the next episode begins with the end of the last (`first`) is in
        # the midst of that.
        self._ended = batch.ended & ~batch.first
        return self._observations(batch), level_infos(batch, self._everywhere)

    def _observations(self, batch: Batch) -> np.ndarray:
        observations = batch.observations
        assert observations is not None
        # What was received is an array of the learner's own already.
        if not self._copy or observations.flags.writeable:
            return observations
        return observations.copy()


def _create_pool(
    client: Client,
    games: str | Sequence[str],
    num_envs: int,
    mode: AutoresetMode,
    options: dict[str, Any],
    *,
    is_drawn: bool,
) -> Pool:
    if is_drawn and not client.catalog().features.render:
        raise UnimplementedError(
            f"the server at {client.address} does not draw for people; use render_mode None"
        )
    if is_local(client) and options.get("encoding", "raw") == "raw":
        options = {"transport": "shared_memory"} | options
    return client.create_pool(games, num_envs, autoreset_mode=_AUTORESET_MODES[mode], **options)


def _close(pool: Pool, client: Client | None) -> None:
    pool.close()
    if client is not None:
        client.close()


def _autoreset_mode(given: AutoresetMode | str) -> AutoresetMode:
    try:
        return AutoresetMode(given)
    except ValueError:
        values = ", ".join(repr(mode.value) for mode in AutoresetMode)
        raise InvalidArgumentError(
            f"autoreset_mode is {given!r}; it is a member of AutoresetMode or one of {values}"
        ) from None


def _reset_mask(given: object, num_envs: int) -> np.ndarray:
    if given is None:
        return np.ones(num_envs, np.bool_)
    if not isinstance(given, np.ndarray) or given.dtype != np.bool_ or given.shape != (num_envs,):
        raise InvalidArgumentError(f"reset_mask is a bool array of shape [{num_envs}]")
    if not given.any():
        raise InvalidArgumentError("reset_mask has no True: it must name at least one environment")
    return given


def _seeds(seed: int | Sequence[int | None] | None, num_envs: int) -> list[int | None]:
    if seed is None:
        return [None] * num_envs
    if isinstance(seed, int | np.integer):
        return [int(seed) + i for i in range(num_envs)]
    if len(seed) != num_envs:
        raise InvalidArgumentError(
            f"seed has {len(seed)} entries; there are {num_envs} environments"
        )
    return [None if value is None else int(value) for value in seed]


def _level_seeds(given: Sequence[int] | None, num_envs: int) -> list[int | None]:
    if given is None:
        return [None] * num_envs
    if len(given) != num_envs:
        raise InvalidArgumentError(
            f"level_seeds has {len(given)} entries; there are {num_envs} environments"
        )
    return [int(value) for value in given]
