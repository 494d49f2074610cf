"""States as dicts that programs read and edit.

::

    state = decode_state(pool.save_states()[0])
    state["agent"]["x"] += 3
    move_goal(state, 20.5, 4.5)
    pool.restore_states({0: encode_state(state)})
"""

from __future__ import annotations

import ctypes
import json
import math
from collections.abc import Callable
from typing import Any, TypedDict, Union, cast

from procgen_client import _library
from procgen_client.errors import InvalidArgumentError, StatusCode
from procgen_client.objects import goals

# Bytes of most states and of their JSON.
_CAPACITY = 1 << 17
_EMPTY = "empty"

# The name of a kind; a number if it has no name.
Kind = Union[str, int]


class Entity(TypedDict, total=False):
    """The agent or another object that is not a cell.

    Numbers are in cells from the bottom left of the level, y upwards. Other fields than kind, x, y,
    vx, vy, rx and ry are missing where they have their default value; envcore/world/entity.h has
    all of them.
    """

    kind: Kind  # Not of the agent.
    x: float  # Center.
    y: float
    vx: float  # Cells per step.
    vy: float
    rx: float  # Half-sizes.
    ry: float
    image_kind: int  # Missing: the number of the kind.
    theme: int  # Index of its image, such as the color of a key. Missing: 0.


class State(TypedDict, total=False):
    """The complete state of an environment.

    It has more fields, those of a snapshot (envcore/environment/README.md): the running episode,
    the choice of levels, and so on.
    """

    game: str
    level_seed: int  # Of the level that was edited, if it was.
    edited: bool  # This episode's state was changed by hand. Read only.
    checksum: int  # Of the snapshot; shows whether something was changed.
    agent: Entity
    entities: list[Entity]  # All others. Their order is part of the rules.
    # The kinds of the cells: grid[y][x] is the cell [x, x + 1) x [y, y + 1), the bottom row first.
    # An array of it works, too.
    grid: list[list[Kind]]
    options: dict[str, Any]
    level: dict[str, Any]  # Step number, random stream, the game's own counters ("own") ...


def decode_state(snapshot: bytes) -> State:
    """Returns a snapshot of save_states as a dict.

    Raises:
        InvalidArgumentError: It is no bytes, or contains an impossible value.
        DataLossError: It is damaged or of another version.
    """
    if not isinstance(snapshot, bytes):
        raise InvalidArgumentError(f"a state is {type(snapshot).__name__}; it is bytes")
    text = _converted(_library.library().state_to_json, snapshot)
    return cast(State, json.loads(text))


def encode_state(state: State) -> bytes:
    """Returns the snapshot of a dict, for restore_states.

    ``encode_state(decode_state(snapshot)) == snapshot``. If something was changed, the snapshot is
    marked (``edited``) until the episode ends, and the fingerprint of the episode differs from that
    of every other one. Numbers are rounded to 32-bit floats; NumPy's arrays and numbers are fine.

    A game's counters do not follow: who takes a diamond away from miner also changes
    ``state["level"]["own"]["diamonds_left"]``.

    Raises:
        InvalidArgumentError: A field is missing, unknown or has a value that no level can have, the
            grid has another size, or the agent is in a cell that blocks it.
    """
    try:
        text = json.dumps(state, default=_plain, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InvalidArgumentError(f"the state cannot be written as JSON: {error}") from error
    return _converted(_library.library().state_from_json, text.encode())


def goal_positions(state: State) -> list[tuple[float, float]]:
    """Returns the centers (x, y) of the goals: entities in their order, then cells.

    A goal is what the agent has to reach, or to collect completely, such as the coin of coinrun.
    bigfish, bossfight, chaser, plunder and starpilot have none.
    """
    entities = [(entity["x"], entity["y"]) for entity in _goal_entities(state)]
    return entities + [(x + 0.5, y + 0.5) for x, y in _goal_cells(state)]


def move_goal(state: State, x: float, y: float) -> None:
    """Moves the goal of a state to (x, y), its new center; a cell moves to the cell there.

    Raises:
        InvalidArgumentError: There is no goal, or more than one, or (x, y) is not in an empty cell.
    """
    entities, cells = _goal_entities(state), _goal_cells(state)
    if len(entities) + len(cells) != 1:
        raise InvalidArgumentError(
            f"the state has {len(entities) + len(cells)} goals; move_goal needs one"
        )
    grid = state["grid"]
    column, row = math.floor(x), math.floor(y)
    if not (0 <= row < len(grid) and 0 <= column < len(grid[row])):
        raise InvalidArgumentError(
            f"the goal's place is ({x}, {y}); the level is {len(grid[0])} x {len(grid)} cells"
        )
    kind = grid[row][column]
    if kind != _EMPTY and (column, row) not in cells:
        raise InvalidArgumentError(f"the cell at ({x}, {y}) is {kind}; a goal needs an empty one")
    if entities:
        entities[0]["x"], entities[0]["y"] = x, y
    else:
        ((old_column, old_row),) = cells
        goal, grid[old_row][old_column] = grid[old_row][old_column], _EMPTY
        grid[row][column] = goal


def remove_goals(state: State) -> None:
    """Takes the goals of a state away. Episodes then end by time, or by what kills the agent.

    encode_state refuses it in games that need theirs (jumper).
    """
    names = goals(state["game"])
    state["entities"] = [
        entity for entity in state["entities"] if entity["kind"] not in names
    ]
    for x, y in _goal_cells(state):
        state["grid"][y][x] = _EMPTY


def _goal_entities(state: State) -> list[Entity]:
    names = goals(state["game"])
    return [entity for entity in state["entities"] if entity["kind"] in names]


def _goal_cells(state: State) -> list[tuple[int, int]]:
    names = goals(state["game"])
    return [
        (x, y) for y, row in enumerate(state["grid"]) for x, kind in enumerate(row) if kind in names
    ]


def _converted(function: Callable[..., int], given: bytes) -> bytes:
    library, size = _library.library(), ctypes.c_size_t()
    capacity = _CAPACITY
    while True:
        output = ctypes.create_string_buffer(capacity)
        code = function(given, len(given), output, capacity, ctypes.byref(size))
        if code != StatusCode.RESOURCE_EXHAUSTED or size.value <= capacity:
            library.check(code)
            return output.raw[: size.value]
        capacity = size.value


def _plain(value: Any) -> Any:  # noqa: ANN401 - NumPy's arrays and numbers
    if not hasattr(value, "tolist"):
        raise TypeError(f"{value!r} is {type(value).__name__}")
    return value.tolist()
