"""The pages of the Python API: directives of autodoc for the package's public names."""

from __future__ import annotations

import inspect

import procgen_client
from procgen_client import options

# Where a name of the package is documented, in the order of the page.
_SECTIONS = {
    "Environments": (
        "ProcgenVectorEnv", "ProcgenGymEnv", "ProcgenEnv", "ProcgenGym3Env", "ToBaselinesVecEnv",
        "AutoresetMode",
    ),
    "Pools": ("Pool", "Batch", "Reset", "LevelSampler", "DoubleBufferedSampler", "catalog"),
    "States": (
        "State", "Objects", "decode_state", "encode_state", "goal_positions", "move_goal",
        "remove_goals",
    ),
    "Servers": ("Client", "connect", "Credentials", "ServerProcess"),
    "Episodes and videos": ("EpisodeStatistics", "Episode", "NormalizeReward", "VideoRecorder"),
    "Constants": ("ACTION_COUNT", "ACTION_MIN", "ENV_NAMES"),
    "Errors": ("ProcgenError",),
}  # fmt: skip
# Classes whose fields are explained by comments, which autodoc does not read.
_SHOWN_AS_SOURCE = ("Batch", "Reset", "LevelSampler", "Episode")


def pages() -> dict[str, str]:
    """Returns the page by its path on the site.

    Raises:
        ValueError: A public name is in no section.
    """
    listed = {name for names in _SECTIONS.values() for name in names}
    if listed != set(procgen_client.__all__):
        raise ValueError(f"_SECTIONS and __all__ differ by {listed ^ set(procgen_client.__all__)}")
    blocks = [_title("Python API", "="), ".. automodule:: procgen_client\n   :no-members:"]
    for section, names in _SECTIONS.items():
        blocks.append(_title(section, "-"))
        for name in names:
            blocks += _entry(name)
        if section == "Pools":
            blocks += [_title("Options", "~"), _source(options.EnvironmentOptions)]
            blocks.append(_source(options.PoolOptions))
        if section == "Errors":
            errors = ".. automodule:: procgen_client.errors\n   :exclude-members: ProcgenError"
            blocks.append(errors)
    blocks += [_title("asyncio", "-"), ".. automodule:: procgen_client.aio"]
    return {"reference/python.rst": "\n\n".join(blocks) + "\n"}


def _entry(name: str) -> list[str]:
    value = getattr(procgen_client, name)
    if not isinstance(value, type):
        kind = "autofunction" if callable(value) else "autodata"
        return [f".. {kind}:: procgen_client.{name}"]
    inherited = "\n   :inherited-members: object" if name == "Pool" else ""
    entry = [f".. autoclass:: procgen_client.{name}{inherited}"]
    if name in _SHOWN_AS_SOURCE:
        entry.append(_source(value))
    return entry


def _source(documented: type) -> str:
    lines = inspect.getsource(documented).rstrip().split("\n")
    return ".. code-block:: python\n\n" + "\n".join("   " + line for line in lines)


def _title(text: str, line: str) -> str:
    return f"{text}\n{line * len(text)}"
