"""A pool as a Gymnasium vector environment."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from procgen_client import _checkpoint
from procgen_client._out import writable_view
from procgen_client._place import Server
from procgen_client._requests import ACTION_COUNT, ENV_COUNT_MAX, Reset, in_range
from procgen_client.batch import Batch
from procgen_client.envs._gymnasium import AutoresetMode, VectorEnv, vector_spaces
from procgen_client.envs._infos import episode_infos, level_dicts, level_infos
from procgen_client.envs._pools import autoreset_mode_of, check_render_mode
from procgen_client.envs._reset_arguments import reset_options_of, seeds_of
from procgen_client.errors import FailedPreconditionError
from procgen_client.objects import Objects
from procgen_client.options import PoolOptions, check_names, keywords_of
from procgen_client.pool import Pool
from procgen_client.pool import option_names as pool_option_names
from procgen_client.tools.art import Art

if TYPE_CHECKING:
    from typing_extensions import Unpack


_FLOAT64 = np.dtype(np.float64)


class ProcgenVectorEnv(VectorEnv):
    """N environments with the contract of Gymnasium's VectorEnv (1.1 and later).

    They are stepped in this process, or on a server.

    A subclass of gymnasium.vector.VectorEnv with Gymnasium 1.1 or later. Without it VectorEnv and
    AutoresetMode are small classes with the same names and attributes.

    Shapes (N = num_envs): observations uint8 [N, 64, 64, 3], RGB, top row first; actions int [N],
    each in [0, 15), or -1, which is outside of the action space and ends the episode; rewards
    float64 [N]; terminations and truncations bool [N]. The time limit truncates an episode, every
    other end terminates it.

    Other observation formats (screen_size, grayscale_obs, layout, frame_stack of
    options.PoolOptions) have shape [N, *pool.observation_shape]. A frame stack adds an axis before
    the frame's, as Gymnasium's FrameStackObservation. A new or restored episode starts with copies
    of one frame.

    Infos, each with a mask ``_key`` of the environments for which it is valid. They are 0 for the
    others, and an info that is valid for none is missing, as in Gymnasium's SyncVectorEnv:

    - ``level_seed`` int64 [N]: level in the observation;
    - ``prev_level_seed`` int64 [N]: level that was stepped; ``prev_level_complete`` bool [N]: this
      step completed it. Not of environments whose observation is the first of an episode;
    - ``episode_return`` float64 [N], ``episode_length`` int64 [N]: of episodes that ended in this
      step;
    - with SAME_STEP, where an episode ended: ``final_obs`` (array of objects: its last observation,
      or None) and ``final_info`` (dict: its last ``level_seed``, ``prev_level_seed``,
      ``prev_level_complete``, and ``episode_return``, ``episode_length``, with masks).

    Arrays that it returns belong to the caller. Threads: one at a time. Pickle and copy.deepcopy
    copy the environments as they are.

    Attributes:
        num_envs: Number of environments, N.
        autoreset_mode: The AutoresetMode, as of Gymnasium's own vector environments.
        pool: The Pool, for calls that the vector environment does not have.
    """

    metadata: dict[str, Any] = {
        "render_modes": ["rgb_array"],
        "render_fps": 15,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    _untouched: bool  # Neither reset nor stepped yet.
    _ended: np.ndarray  # Episode over; with DISABLED to be reset.   bool [N]
    _next_levels: dict[int, int]  # Sent with the next step.

    def __init__(
        self,
        games: str | Sequence[str],
        num_envs: int = 64,
        *,
        server: Server = None,
        art: Art | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        render_size_px: int = 512,
        frame_skip: int = 1,
        **options: Unpack[PoolOptions],
    ) -> None:
        """Makes the environments.

        Args:
            games, num_envs: A game, or several, which alternate; number of environments, N.
            server, art: As for Pool: None, and they are stepped in this process.
            autoreset_mode: A member of AutoresetMode or its value. With NEXT_STEP, the step after
                an episode's end ignores its action: learners must mask that row.
            render_mode: "rgb_array" for render(), or None.
            render_size_px: Side of render's square frames, in pixels.
            frame_skip: How often each action is repeated, in [1, 1000]. Only the last observation
                is rendered, rewards are summed, and the end of an episode stops its environment.
            **options: Options of Procgen 0.10.7 (distribution_mode, num_levels, start_level,
                rand_seed, use_sequential_levels, ...), observation format (screen_size,
                grayscale_obs, layout, frame_stack), num_threads and others: options.PoolOptions.

        Raises:
            InvalidArgumentError: An argument is unknown (UnknownOptionError), of a wrong type or
                out of range; or `art` with a server.
            NotFoundError: There is no such game or art.
            UnimplementedError: render_mode is "rgb_array", and the server has no rendering.
            ProcgenError: As Pool.
        """
        check_names(type(self).__name__, options, option_names())
        num_envs = in_range("num_envs", num_envs, 1, ENV_COUNT_MAX)
        mode = autoreset_mode_of(autoreset_mode)
        check_render_mode(render_mode)
        self._frame_skip = in_range("frame_skip", frame_skip, 1, 1000)
        self.pool = Pool(
            *(games, num_envs),
            server=server,
            art=art,
            autoreset_mode=mode.name.lower(),
            **options,
        )
        self.num_envs, self.render_mode = num_envs, render_mode
        self.autoreset_mode = mode
        self.metadata = self.metadata | {"autoreset_mode": mode}
        self.__dict__ |= vector_spaces(self.pool.observation_shape, ACTION_COUNT, num_envs)
        self._render_size_px = render_size_px
        self._returns_final = mode is AutoresetMode.SAME_STEP
        self._everywhere, self._nowhere = np.ones(num_envs, np.bool_), np.zeros(num_envs, np.bool_)
        self._untouched, self._ended, self._next_levels = True, self._nowhere.copy(), {}

    def __enter__(self) -> ProcgenVectorEnv:
        """Returns the environment itself."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Closes the environment."""
        self.close()

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Starts new episodes and returns the first observations.

        Args:
            seed: New seed of the choice of levels: seed + i for environment i, or seed[i] (None:
                unchanged). None: all unchanged; the first reset then returns the episodes that
                rand_seed chose, as in upstream.
            options: ``reset_mask``, bool [N] with at least one True: only these environments are
                reset. ``level_seeds``, or ``level_seed``: the levels to play, int [N], or one int
                for all. The dict is not modified, since wrappers read it afterwards.
            out: As step.

        Returns:
            Observations, and the info ``level_seed``; ``_level_seed`` is the reset_mask.

        Raises:
            InvalidArgumentError: `seed` has a wrong length or is out of range, an option is unknown
                or malformed, or `out` is malformed.
            FailedPreconditionError: The environment is closed.
        """
        self._require_open()
        mask, levels = reset_options_of(options, self.num_envs, type(self).__name__)
        seeds = seeds_of(seed, self.num_envs)
        if self._untouched and mask.all() and seed is None and levels[0] is None:
            batch = self.pool.observe(out=out)
        else:
            batch = self.pool.reset(
                [Reset(int(i), levels[i], seeds[i]) for i in np.flatnonzero(mask)], out=out
            )
        self._untouched = False
        self._ended[mask] = False
        return batch.observations, level_infos(batch, mask, self._nowhere)

    def step(
        self,
        actions: npt.ArrayLike,
        *,
        annotations: Mapping[str, npt.ArrayLike] | None = None,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Steps all environments.

        Args:
            actions: int [N], each in [0, 15), or -1.
            annotations: Values for viewers, by name, as for :meth:`Pool.step`.
            out: Receives the observations, and is returned in their place: a writable,
                C-contiguous array or tensor, uint8 [N, *pool.observation_shape]: a numpy array, a
                torch tensor on the CPU (also in pinned memory) or a buffer.

        Returns:
            Observations, rewards, terminations, truncations, infos.

        Raises:
            InvalidArgumentError: `actions` has a wrong length or a value out of range, or `out` is
                malformed. Nothing was stepped.
            FailedPreconditionError: With DISABLED, an environment's episode is over: reset it. Or
                step_async was called without step_wait. Nothing was stepped.
        """
        self._check_step()
        batch = self.pool.step(
            actions,
            repeat_count=self._frame_skip,
            final_observations=self._returns_final,
            next_levels=self._next_levels,
            annotations=annotations,
            out=out,
        )
        return self._results_of(batch)

    def step_async(
        self, actions: npt.ArrayLike, *, annotations: Mapping[str, npt.ArrayLike] | None = None
    ) -> None:
        """Begins a step of all environments; step_wait returns its results.

        As in Gymnasium's AsyncVectorEnv. They are stepped while the program does other work. Only
        step_wait may follow. Arguments and errors as step.
        """
        self._check_step()
        self.pool.send_step(
            actions,
            repeat_count=self._frame_skip,
            final_observations=self._returns_final,
            next_levels=self._next_levels,
            annotations=annotations,
        )
        self._next_levels = {}

    def step_wait(
        self,
        *,
        out: Any = None,  # noqa: ANN401 - an array or tensor
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Waits for the step that step_async began, and returns the values of step.

        Args:
            out: As step; the observations are copied.

        Raises:
            InvalidArgumentError: `out` is malformed. Nothing was received.
            FailedPreconditionError: step_async was not called.
            ProcgenError: Any error of the server.
        """
        self._require_open()
        if not self.pool.in_flight:
            raise FailedPreconditionError("step_async was not called: call it first")
        view = None
        if out is not None:
            view = writable_view(out, (self.num_envs, *self.pool.observation_shape))
        batch = self.pool.receive()
        if view is not None:
            np.copyto(view, batch.observations)
            batch.observations = out
        return self._results_of(batch)

    def set_next_levels(self, level_seeds: Mapping[int, int]) -> None:
        """Chooses the levels of the next episodes of some environments.

        Sent with the next step, and valid until they are played, also if that step ends the
        episode.

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
        """Whether the last step ended the episode and the next has not started; bool [N]."""
        if self._returns_final:
            return np.zeros(self.num_envs, np.bool_)
        return self._ended.copy()

    def save_states(self, environments: Sequence[int] | None = None) -> list[bytes]:
        """Returns snapshots of environments (None: all); see Pool.save_states."""
        self._require_open()
        return self.pool.save_states(environments)

    def restore_states(
        self, states: Mapping[int, bytes] | Sequence[bytes]
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Restores saved states and returns observations and infos of all.

        Args:
            states: Snapshots by environment, or a list with one for each; see Pool.restore_states.

        Returns:
            Observations and infos, as reset.
        """
        self.pool.restore_states(states)
        return self._observe()

    def clone_states(
        self, pairs: Iterable[tuple[int, int]]
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Copies states between environments and returns observations and infos of all.

        Args:
            pairs: (source, target) environments; see Pool.clone_states.

        Returns:
            Observations and infos, as reset.
        """
        self.pool.clone_states(pairs)
        return self._observe()

    def objects(self, objects_max: int = 64) -> Objects:
        """Returns the objects of all environments as arrays; see Pool.objects."""
        self._require_open()
        return self.pool.objects(objects_max)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a checkpoint of all environments, from which :meth:`load` continues bit for bit.

        As of restore_states, two things are not part of it: frame stacks, which start with copies
        of one frame, and the list of a level sampler. A failure leaves the file as it was.

        Raises:
            OSError: The file cannot be written.
            ProcgenError: As Pool.save_states.
        """
        state = _checkpoint.WrapperState(self._ended, self._untouched, self._next_levels)
        _checkpoint.save(path, self.pool, state)

    def load(self, path: str | os.PathLike[str]) -> tuple[np.ndarray, dict[str, Any]]:
        """Restores a checkpoint of :meth:`save` and returns observations and infos, as reset.

        Options of the game and the choice of levels come from the checkpoint. If it was saved with
        a level sampler, this environment has the same.

        Raises:
            OSError: The file cannot be read.
            DataLossError: The file is damaged, truncated, or of another version.
            InvalidArgumentError: It is of other games, another number of environments or another
                autoreset mode. Nothing was restored.
        """
        state = _checkpoint.load(path, self.pool)
        observed = self._observe()
        self._ended, self._untouched, self._next_levels = state
        return observed

    def get_info(self) -> list[dict[str, Any]]:
        """Returns infos as upstream's gym3 environment does.

        Returns:
            A dict for each environment: ``prev_level_seed``, ``prev_level_complete``,
            ``level_seed``; with a render_mode also ``rgb``, as :meth:`render` returns it.
        """
        self._require_open()
        infos = level_dicts(self.pool.observe(observe=False))
        for info, frame in zip(infos, self.render() or ()):
            info["rgb"] = frame
        return infos

    def render(self) -> tuple[np.ndarray, ...] | None:
        """Renders all environments for people: N frames, uint8 [side, side, 3].

        None if render_mode is None.
        """
        self._require_open()
        if self.render_mode is None:
            return None
        return tuple(self.pool.render(size_px=self._render_size_px))

    def close_extras(self, **kwargs: Any) -> None:
        """Closes the pool."""
        if hasattr(self, "pool"):  # False if __init__ failed.
            self.pool.close()

    def _require_open(self) -> None:
        if self.closed:
            raise FailedPreconditionError("the environment is closed: make another one")

    def _check_step(self) -> None:
        self._require_open()
        if self.pool.in_flight:
            raise FailedPreconditionError("step_async was called before; call step_wait first")
        if self.autoreset_mode is AutoresetMode.DISABLED and self._ended.any():
            raise FailedPreconditionError(
                f"the episodes of environments {np.flatnonzero(self._ended).tolist()} are over: "
                'reset them with options={"reset_mask": ...}'
            )

    def _results_of(
        self, batch: Batch
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Returns the values of step: copies, so that the batch's memory can be used again."""
        self._untouched = False
        if self._next_levels:
            self._next_levels = {}
        terminated, truncated = batch.terminated.copy(), batch.truncated.copy()
        self._ended = ended = terminated | truncated
        infos = level_infos(batch, self._everywhere, self._stepped(batch))
        if np.count_nonzero(ended):  # Five times as fast as any().
            infos |= episode_infos(batch, ended, self._returns_final)
        return batch.observations, batch.rewards.astype(_FLOAT64), terminated, truncated, infos

    def _observe(self) -> tuple[np.ndarray, dict[str, Any]]:
        batch = self.pool.observe()
        self._untouched = False
        # `first`: saved in a pool with "same_step", where the next episode has already started.
        self._ended = batch.ended & ~batch.first
        infos = level_infos(batch, self._everywhere, self._stepped(batch))
        return batch.observations, infos

    def _stepped(self, batch: Batch) -> np.ndarray:
        """Returns which environments stepped a level of their current episode, bool [N].

        With NEXT_STEP, the others start the next episode; with SAME_STEP, final_info has their
        step.
        """
        return ~batch.first if np.count_nonzero(batch.first) else self._everywhere


def option_names() -> set[str]:
    """Returns the names of all arguments of ProcgenVectorEnv."""
    renamed = {"env_count"}  # num_envs
    return keywords_of(ProcgenVectorEnv.__init__) | pool_option_names() - renamed
