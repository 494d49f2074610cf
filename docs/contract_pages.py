"""Pages of the gRPC API, from the comments of the protos."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from google.protobuf import descriptor_pb2 as descriptors
from markdown import escaped, from_comment, table

PROTO = Path(__file__).resolve().parents[1] / "proto"
# Field numbers of descriptor.proto, of which the paths of comments consist.
_MESSAGE, _ENUM, _SERVICE = 4, 5, 6
_FIELD, _NESTED_MESSAGE, _NESTED_ENUM, _METHOD, _VALUE = 2, 3, 4, 2, 2

_Path = tuple[int, ...]
_Types = descriptors.FieldDescriptorProto


def pages() -> dict[str, str]:
    """Returns a page for each file, and the one that lists them, by path on the site."""
    result, names = {}, []
    for file in _files():
        page = _Page(file)
        name = Path(file.name).stem
        names.append(name)
        result[f"reference/contract/{name}.md"] = page.text()
    contents = "\n".join(f"contract/{name}" for name in names)
    result["reference/contract.md"] = (
        "# gRPC API\n\nThe services and messages of `procgen.v1`, generated from the comments of "
        "its protos. [The guide for authors of clients](../proto/index.md) explains terms, the "
        f"life of a stream and errors.\n\n```{{toctree}}\n{contents}\n```\n"
    )
    return result


def _files() -> list[descriptors.FileDescriptorProto]:
    names = sorted(str(path.relative_to(PROTO)) for path in PROTO.glob("procgen/v1/*.proto"))
    with tempfile.NamedTemporaryFile() as output:
        subprocess.run(
            ["protoc", "-I", PROTO, "--include_source_info", "-o", output.name, *names], check=True
        )
        return list(descriptors.FileDescriptorSet.FromString(Path(output.name).read_bytes()).file)


class _Page:
    """The page of one file."""

    def __init__(self, file: descriptors.FileDescriptorProto) -> None:
        self._file = file
        self._comments = {
            tuple(at.path): at.leading_comments or at.trailing_comments
            for at in file.source_code_info.location
        }

    def text(self) -> str:
        blocks = [f"# {Path(self._file.name).name}", f"`{self._file.name}`"]
        for i, service in enumerate(self._file.service):
            blocks += self._service(service, (_SERVICE, i))
        for i, message in enumerate(self._file.message_type):
            blocks += self._message(message, (_MESSAGE, i), "")
        for i, enum in enumerate(self._file.enum_type):
            blocks += self._enum(enum, (_ENUM, i), "")
        return "\n\n".join(block for block in blocks if block) + "\n"

    def _lines(self, path: _Path) -> list[str]:
        comment = self._comments.get(path, "")
        return [line.removeprefix(" ").rstrip() for line in comment.strip("\n").split("\n")]

    def _service(
        self, service: descriptors.ServiceDescriptorProto, path: _Path
    ) -> Iterator[str]:
        yield f"## Service {service.name}"
        yield from_comment(self._lines(path))
        for i, method in enumerate(service.method):
            request = "stream " * method.client_streaming + _short(method.input_type)
            response = "stream " * method.server_streaming + _short(method.output_type)
            yield f"### {method.name}"
            yield f"```text\nrpc {method.name}({request}) returns ({response})\n```"
            yield from_comment(self._lines((*path, _METHOD, i)))

    def _message(
        self, message: descriptors.DescriptorProto, path: _Path, outer: str
    ) -> Iterator[str]:
        if message.options.map_entry:
            return
        name = outer + message.name
        yield f"## {name}"
        yield from_comment(self._lines(path))
        rows = []
        for i, field in enumerate(message.field):
            choice = ""
            if field.HasField("oneof_index") and not field.proto3_optional:
                choice = f" (one of {message.oneof_decl[field.oneof_index].name})"
            meaning = " ".join(line.strip() for line in self._lines((*path, _FIELD, i)))
            rows.append([f"`{field.name}`{choice}", _type(field, message), escaped(meaning)])
        if rows:
            yield table(["field", "type", "meaning"], rows)
        for i, nested in enumerate(message.nested_type):
            yield from self._message(nested, (*path, _NESTED_MESSAGE, i), name + ".")
        for i, enum in enumerate(message.enum_type):
            yield from self._enum(enum, (*path, _NESTED_ENUM, i), name + ".")

    def _enum(
        self, enum: descriptors.EnumDescriptorProto, path: _Path, outer: str
    ) -> Iterator[str]:
        yield f"## {outer}{enum.name}"
        yield from_comment(self._lines(path))
        rows = []
        for i, value in enumerate(enum.value):
            meaning = " ".join(line.strip() for line in self._lines((*path, _VALUE, i)))
            rows.append([f"`{value.name}`", str(value.number), escaped(meaning)])
        yield table(["value", "number", "meaning"], rows)


def _short(name: str) -> str:
    return name.removeprefix(".procgen.v1.").removeprefix(".")


def _type(field: _Types, message: descriptors.DescriptorProto) -> str:
    for nested in message.nested_type:
        if nested.options.map_entry and field.type_name.endswith("." + nested.name):
            key, value = (_scalar(each) for each in nested.field)
            return f"map of {key} to {value}"
    prefix = {_Types.LABEL_REPEATED: "repeated "}.get(field.label, "")
    return prefix + ("optional " if field.proto3_optional else "") + _scalar(field)


def _scalar(field: _Types) -> str:
    if field.type_name:
        return f"`{_short(field.type_name)}`"
    return _Types.Type.Name(field.type).removeprefix("TYPE_").lower()
