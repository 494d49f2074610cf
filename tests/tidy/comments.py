"""The prose of the repository: Markdown pages, and the comments of its sources."""

import ast
import re

# In C++, protos and JavaScript: literals, which may contain comment marks, and
# comments. A template or raw string is a literal, too.
_LITERAL_OR_COMMENT = re.compile(
    r'R"\((?:.|\n)*?\)"'
    r"|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|`(?:\\.|[^`\\])*`"
    r"|//[^\n]*|/\*(?:.|\n)*?\*/")
_C_LIKE = (".h", ".cc", ".c", ".proto", ".js")
_MARKS = re.compile(r"\s*\*+/\s*$|^\s*(?://+|/\*+|\*+/|\*|#+)?!?\s?")


def _c_like_lines(text):
    number, at = 1, 0
    for match in _LITERAL_OR_COMMENT.finditer(text):
        number += text.count("\n", at, match.start())
        at = match.start()
        if match.group().startswith(("//", "/*")):
            yield from enumerate(match.group().split("\n"), start=number)


def _python_lines(text):
    """Whole-line comments, comments after code, and docstrings."""
    # A '#' within a string counts as a comment if a blank is before and behind it, which is rare.
    for number, line in enumerate(text.split("\n"), start=1):
        match = re.search(r"(?:^|\s)# (.*)", line)
        if match:
            yield number, match.group(1)
    try:
        module = ast.parse(text)
    except SyntaxError:
        return
    for node in ast.walk(module):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            docstring = node.body and ast.get_docstring(node, clean=False)
            if docstring:
                yield from enumerate(docstring.split("\n"), start=node.body[0].lineno)


def prose_of(path, text):
    """Pairs of line number and prose, without comment marks; empty for other kinds of files."""
    if path.endswith(".md"):
        return list(enumerate(text.split("\n"), start=1))
    if path.endswith(_C_LIKE):
        lines = _c_like_lines(text)
    elif path.endswith(".py"):
        lines = _python_lines(text)
    else:
        return []
    return sorted((number, _MARKS.sub("", line)) for number, line in lines)


def blocks_of(path, text):
    """Groups pairs of successive lines, because sentences span lines."""
    blocks = []
    for number, line in prose_of(path, text):
        if blocks and number <= blocks[-1][-1][0] + 1:
            blocks[-1].append((number, line))
        else:
            blocks.append([(number, line)])
    return blocks
