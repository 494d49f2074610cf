"""Names: of files, folders and types, and the guards that headers take from their paths."""

import posixpath
import re

from includes import INCLUDE_ROOTS, cpp_files
from source_tree import Violation

# Words that say nothing about what a thing is.
EMPTY_WORDS = frozenset("""
    util utils utility utilities misc miscellaneous common commons helper helpers manager managers
    stuff
""".split())

_ADVICE = "says nothing; name it after what it is or does"


def _words(name):
    """camelCase, snake_case and kebab-case taken apart: 'GrpcUtil' -> ['grpc', 'util']."""
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)]


def _empty_word(name):
    return next((word for word in _words(name) if word in EMPTY_WORDS), None)


def check_file_names(tree):
    """No file or folder is named by a word that says nothing."""
    reported = set()
    for path in tree.paths:
        parts = path.split("/")
        for depth, part in enumerate(parts, start=1):
            place = "/".join(parts[:depth])
            word = _empty_word(part)
            if word and place not in reported:
                reported.add(place)
                yield Violation(place, 1, f"'{word}' in a file's name {_ADVICE}")


_CPP_DECLARATION = re.compile(
    r"\s*(?:template\s*<.*>\s*)?(?:class|struct|enum|enum class|union|namespace|using)\s+(\w+)\s*"
    r"(?:final\s*)?[:{=]")
_PYTHON_DECLARATION = re.compile(r"\s*(?:class|def)\s+(\w+)")
_PROTO_DECLARATION = re.compile(r"\s*(?:message|enum|service|rpc)\s+(\w+)")
_CMAKE_DECLARATION = re.compile(r"\s*(?:add_library|add_executable|function|macro)\s*\(\s*(\w+)")
_DECLARATIONS = {".h": _CPP_DECLARATION, ".cc": _CPP_DECLARATION, ".py": _PYTHON_DECLARATION,
                 ".proto": _PROTO_DECLARATION, ".txt": _CMAKE_DECLARATION}


def check_declared_names(tree):
    """No type, namespace, Python function, message or target is named by such a word."""
    for path in tree.with_suffix(".h", ".cc", ".py", ".proto", "CMakeLists.txt"):
        pattern = _DECLARATIONS[posixpath.splitext(path)[1]]
        for number, line in tree.lines(path):
            match = pattern.match(line)
            word = match and _empty_word(match.group(1))
            if word:
                yield Violation(path, number, f"'{word}' in {match.group(1)} {_ADVICE}")


def guard_of(path):
    """The include guard that a header at `path` must have."""
    for root in INCLUDE_ROOTS:
        path = path.removeprefix(root)
    return re.sub(r"[^A-Za-z0-9]", "_", path).upper() + "_"


def check_header_guards(tree):
    """The guard of a header is its path: #ifndef, #define, and #endif with the name behind."""
    for path in tree.with_suffix(".h"):
        guard = guard_of(path)
        code = [(number, line) for number, line in tree.lines(path)
                if line.strip() and not line.startswith("//")]
        wanted = ((0, f"#ifndef {guard}"), (1, f"#define {guard}"), (-1, f"#endif  // {guard}"))
        if len(code) < len(wanted):
            yield Violation(path, 1, f"has no include guard; it should be {guard}")
            continue
        for index, expected in wanted:
            number, line = code[index]
            if line != expected:
                yield Violation(path, number, f"the guard follows the path; write '{expected}'")
                break


def check_impl_names(tree):
    """'Impl' is only for the class behind a generated service."""
    for path in cpp_files(tree):
        if path.startswith("server/rpc/"):
            continue
        for number, line in tree.lines(path):
            match = re.match(r"\s*(?:class|struct)\s+(\w*Impl)\b", line)
            if match:
                yield Violation(path, number, f"{match.group(1)}: 'Impl' is only for the class "
                                              "behind a generated service; say what it is")


RULES = (check_file_names, check_declared_names, check_header_guards, check_impl_names)
