"""Files of checkpoints: tensors and JSON, whose loading executes no code of the file."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import IO, Any

import numpy as np
import torch

_HEADER = "header"


def save(file: IO[bytes], checkpoint: dict[str, Any]) -> None:
    """Writes a checkpoint.

    Args:
        file: Receives it.
        checkpoint: Dicts, lists, tuples, numbers, strings, None, bytes, tensors and numpy arrays.

    Raises:
        TypeError: A value of another type.
    """
    tensors: list[torch.Tensor] = []
    header = json.dumps(_described(checkpoint, tensors)).encode()
    named = {str(i): tensor for i, tensor in enumerate(tensors)}
    torch.save({_HEADER: _tensor_of(np.frombuffer(header, np.uint8))} | named, file)


def load(path: Path, device: torch.device | str = "cpu") -> dict[str, Any]:
    """Returns the checkpoint in a file, with its tensors on `device`.

    Raises:
        OSError: The file cannot be read.
        ValueError: It is no such file.
    """
    try:
        tensors = torch.load(path, map_location=device, weights_only=True)
        header = json.loads(tensors[_HEADER].cpu().numpy().tobytes())
    except (pickle.UnpicklingError, RuntimeError, LookupError, TypeError, ValueError) as error:
        raise ValueError(f"{path} is not a checkpoint of these learners: {error}") from None
    checkpoint: dict[str, Any] = _value_of(header, tensors)
    return checkpoint


def _described(value: Any, tensors: list[torch.Tensor]) -> Any:  # noqa: ANN401
    """Returns a value as JSON: a scalar, or [kind, content]. Appends its tensors to `tensors`."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, dict):
        return ["dict", [[key, _described(each, tensors)] for key, each in value.items()]]
    if isinstance(value, list | tuple):
        kind = "list" if isinstance(value, list) else "tuple"
        return [kind, [_described(each, tensors) for each in value]]
    if isinstance(value, torch.Tensor):
        kind, tensor = "tensor", value
    elif isinstance(value, np.ndarray):
        kind, tensor = "array", _tensor_of(value)
    elif isinstance(value, bytes):
        kind, tensor = "bytes", _tensor_of(np.frombuffer(value, np.uint8))
    else:
        raise TypeError(f"a checkpoint has a {type(value).__name__}; save plain values and tensors")
    tensors.append(tensor)
    return [kind, len(tensors) - 1]


def _value_of(described: Any, tensors: dict[str, torch.Tensor]) -> Any:  # noqa: ANN401
    if not isinstance(described, list):
        return described
    kind, content = described
    if kind == "dict":
        return {key: _value_of(each, tensors) for key, each in content}
    if kind in ("list", "tuple"):
        values = [_value_of(each, tensors) for each in content]
        return values if kind == "list" else tuple(values)
    tensor = tensors[str(content)]
    if kind == "tensor":
        return tensor
    array = tensor.cpu().numpy()
    return array if kind == "array" else array.tobytes()


def _tensor_of(array: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(np.array(array))  # A copy, because PyTorch warns of read-only ones.
