"""Limits on the sizes of lines, functions and files."""

import ast
import re

from includes import cpp_files
from source_tree import Violation

LINE_LENGTH_MAX = 100
FUNCTION_LINES_MAX = 70
FILE_LINES_MAX = 500

_SOURCES = (".h", ".cc", ".py", ".sh", ".proto", ".js", "CMakeLists.txt", ".cmake")


def check_line_length(tree):
    """C++ and Python lines have at most 100 characters."""
    for path in tree.with_suffix(".h", ".cc", ".py"):
        for number, line in tree.lines(path):
            # Includes and links cannot be broken.
            unbreakable = line.lstrip().startswith("#include") or "://" in line
            if len(line) > LINE_LENGTH_MAX and not unbreakable:
                yield Violation(path, number, f"has {len(line)} characters; the limit is "
                                              f"{LINE_LENGTH_MAX}")


def check_file_length(tree):
    """A source file has at most 500 lines."""
    for path in tree.with_suffix(*_SOURCES):
        count = len(tree.lines(path))
        if count > FILE_LINES_MAX:
            yield Violation(path, count, f"has {count} lines; the limit is {FILE_LINES_MAX}; "
                                         "split it by concept")


def check_python_function_length(tree):
    """A Python function has at most 70 lines; tests may be longer."""
    for path in tree.with_suffix(".py"):
        if _may_be_long(path):
            continue
        try:
            module = ast.parse(tree.text(path))
        except SyntaxError as error:
            yield Violation(path, error.lineno or 1, "has a syntax error")
            continue
        for node in ast.walk(module):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                yield from _check_length(path, node.name, node.lineno, node.end_lineno)


def check_cpp_function_length(tree):
    """A C++ function has at most 70 lines; tests may be longer."""
    for path in cpp_files(tree):
        if not _may_be_long(path):
            for name, first, last in cpp_functions(tree.text(path)):
                yield from _check_length(path, name, first, last)


def _may_be_long(path):
    return path.startswith("tests/") and path.endswith(("_test.cc", "_test.py"))


def _check_length(path, name, first, last):
    count = last - first + 1
    if count > FUNCTION_LINES_MAX:
        yield Violation(path, first, f"{name} has {count} lines; the limit is "
                                     f"{FUNCTION_LINES_MAX}; extract a function")


_NOT_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
_DIGIT_SEPARATOR = re.compile(r"(?<=[0-9a-fA-F])'(?=[0-9a-fA-F])")
_TYPE_OR_SPACE = re.compile(
    r"\s*(?:(?:public|private|protected):\s*)*(?:template\s*<.*>\s*)?"
    r"(?:class|struct|union|enum|namespace|extern)\b", re.DOTALL)
_FUNCTION_NAME = re.compile(r"([\w:~]+)\s*\(")


def cpp_functions(text):
    """Yields (name, first line, last line) of the functions with a body.

    An approximation that is exact enough with clang-format's layout: a brace opens a function if
    the text since the last ';', '{' or '}' has a parameter list and opens no type or namespace.
    Blocks, lambdas and local types belong to the function that contains them.
    """
    text = _code_of(text)
    depth, function, head_start = 0, None, 0
    for match in re.finditer(r"[{};]", text):
        sign = match.group()
        if sign == "{":
            head = text[head_start:match.start()]
            name = _FUNCTION_NAME.search(head)
            if function is None and name and not _TYPE_OR_SPACE.match(head):
                start = head_start + len(head) - len(head.lstrip())
                function = (name.group(1), text.count("\n", 0, start) + 1, depth)
            depth += 1
        elif sign == "}":
            depth -= 1
            if function is not None and depth == function[2]:
                yield function[0], function[1], text.count("\n", 0, match.start()) + 1
                function = None
        head_start = match.end()


def _code_of(text):
    """Replaces comments, literals and preprocessor lines by blanks; offsets stay the same."""
    text = _DIGIT_SEPARATOR.sub("", text)
    text = _NOT_CODE.sub(_blank, text)
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", _blank, text, flags=re.MULTILINE)


def _blank(match):
    return re.sub(r"[^\n]", " ", match.group())


RULES = (check_line_length, check_file_length, check_python_function_length,
         check_cpp_function_length)
