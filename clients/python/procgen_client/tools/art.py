"""Folders of art to draw with."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path
from typing import Union

from procgen_client.errors import InvalidArgumentError, NotFoundError

# Default art of pools in this process: a folder, or INSTALLED.
ART_VARIABLE = "PROCGEN_ART"
# The art of the installed package `procgen` (Procgen 0.10.7, "upstream").
INSTALLED = "procgen"

Art = Union[str, "os.PathLike[str]"]


def art_folder(art: Art | None) -> str | None:
    """Returns the folder of a pool in this process; None: the built-in art. Errors as art_dir."""
    given = os.environ.get(ART_VARIABLE) if art is None else art
    return None if given is None else art_dir(given)


def art_dir(art: Art) -> str:
    """Returns the path of a folder of art.

    Args:
        art: A folder in upstream's layout, or "procgen": the folder ``data/assets`` of the
            installed package `procgen`, which is not imported. A folder named procgen is
            "./procgen".

    Raises:
        InvalidArgumentError: `art` is empty.
        NotFoundError: There is no such folder or package.
    """
    if not os.fspath(art):
        raise InvalidArgumentError('art is empty; it is a folder, or "procgen"')
    folders = _installed() if art == INSTALLED else [Path(art)]
    for folder in folders:
        if folder.is_dir():
            return os.path.abspath(folder)
    if art == INSTALLED:
        where = f"has no folder {folders[0]}" if folders else "is not installed"
        raise NotFoundError(
            f"art is 'procgen', but the package procgen {where}: pip install procgen==0.10.7, or "
            "give a folder with its data/assets"
        )
    raise NotFoundError(
        f"art is {os.fspath(art)}, which is no folder; it is a folder with the data/assets of the "
        "package procgen, or 'procgen' where that is installed"
    )


def upstream_is_installed() -> bool:
    """Whether the package `procgen` is upstream's: other packages of that name have no art."""
    return any(folder.is_dir() for folder in _installed())


def _installed() -> list[Path]:
    """Where the installed package has its art; empty: it is not installed."""
    try:
        spec = importlib.util.find_spec("procgen")
    except ValueError:  # The program has made a module of that name.
        return []
    found = [] if spec is None else spec.submodule_search_locations or []
    return [Path(folder) / "data/assets" for folder in found]
