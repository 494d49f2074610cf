"""Names of files, folders and types; include guards."""

import posixpath
import re

from includes import INCLUDE_ROOTS
from source_tree import Violation

# Words that do not describe what is named.
VAGUE_WORDS = frozenset("""
    util utils utility utilities misc miscellaneous common commons helper helpers manager managers
    stuff
""".split())

_ADVICE = "is vague; name it after what it is or does"


def _words(name):
    """Splits camelCase, snake_case and kebab-case: 'GrpcUtil' -> ['grpc', 'util']."""
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)]


def _vague_word(name):
    return next((word for word in _words(name) if word in VAGUE_WORDS), None)


def check_file_names(tree):
    """No file or folder has a vague word in its name."""
    reported = set()
    for path in tree.paths:
        parts = path.split("/")
        for depth, part in enumerate(parts, start=1):
            prefix = "/".join(parts[:depth])
            word = _vague_word(part)
            if word and prefix not in reported:
                reported.add(prefix)
                yield Violation(prefix, 1, f"'{word}' in a file's name {_ADVICE}")


_CPP_DECLARATION = re.compile(
    r"\s*(?:template\s*<.*>\s*)?(?:class|struct|enum|enum class|union|namespace|using)\s+(\w+)\s*"
    r"(?:final\s*)?[:{=]")
_PYTHON_DECLARATION = re.compile(r"\s*(?:class|def)\s+(\w+)")
_PROTO_DECLARATION = re.compile(r"\s*(?:message|enum|service|rpc)\s+(\w+)")
_CMAKE_DECLARATION = re.compile(r"\s*(?:add_library|add_executable|function|macro)\s*\(\s*(\w+)")
_DECLARATIONS = {".h": _CPP_DECLARATION, ".cc": _CPP_DECLARATION, ".py": _PYTHON_DECLARATION,
                 ".proto": _PROTO_DECLARATION, ".txt": _CMAKE_DECLARATION}


def check_declared_names(tree):
    """No declared type, function, message or target has a vague word in its name."""
    for path in tree.with_suffix(".h", ".cc", ".py", ".proto", "CMakeLists.txt"):
        pattern = _DECLARATIONS[posixpath.splitext(path)[1]]
        for number, line in tree.lines(path):
            match = pattern.match(line)
            word = match and _vague_word(match.group(1))
            if word:
                yield Violation(path, number, f"'{word}' in {match.group(1)} {_ADVICE}")


def guard_of(path):
    """Returns the required include guard of the header at `path`."""
    for root in INCLUDE_ROOTS:
        path = path.removeprefix(root)
    return re.sub(r"[^A-Za-z0-9]", "_", path).upper() + "_"


def check_header_guards(tree):
    """The include guard of a header is its path, repeated behind #endif."""
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
                yield Violation(path, number, f"the guard is the path; write '{expected}'")
                break


RULES = (check_file_names, check_declared_names, check_header_guards)
