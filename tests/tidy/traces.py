"""Traces of work that must not be published: markers, conflicts, machine paths."""

import re

from source_tree import Violation

# Files with text from other projects.
_FOREIGN = ("LICENSE",)

# Taken apart so that this file does not report itself.
_MARKER = re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X|HA" r"CK)\b")
# Places that exist on somebody's machine only.
_MACHINE_PATH = re.compile(r"(?<![\w.~$}])/(work|ro" r"ot|home/\w+|Users/\w+|mnt/\w+)/\w"
                           r"|\b[A-Z]:\\Users\\")


def _text_lines(tree):
    for path in tree.paths:
        if path not in _FOREIGN:
            for number, line in tree.lines(path):
                yield path, number, line


def check_markers(tree):
    """No marker of unfinished work stays in a file; the list of work is kept elsewhere."""
    for path, number, line in _text_lines(tree):
        match = _MARKER.search(line)
        if match:
            yield Violation(path, number, f"{match.group(1)}: do it or open an issue; markers in "
                                          "files are forgotten")


# "=======" alone would do for Markdown's headings, so it does not count.
_CONFLICT = re.compile(r"(<{7}|>{7}|\|{7})( |$)")


def check_conflicts(tree):
    """No file contains merge conflict markers."""
    for path, number, line in _text_lines(tree):
        if _CONFLICT.match(line):
            yield Violation(path, number, "a merge was not finished here; choose what stays")


def check_machine_paths(tree):
    """No file contains a path of a developer's machine."""
    for path, number, line in _text_lines(tree):
        match = _MACHINE_PATH.search(line)
        if match:
            yield Violation(path, number, f"'{match.group()}...' is a path of one machine; make it "
                                          "relative or an option")


def check_blanks(tree):
    """No line ends with a blank, no source has a tab, a text ends with exactly one newline."""
    for path in tree.paths:
        text = tree.text(path)
        if path in _FOREIGN or not text:
            continue
        for number, line in tree.lines(path):
            if line != line.rstrip():
                yield Violation(path, number, "ends with a blank; remove it")
            elif line.startswith("\t") and path.endswith((".h", ".cc", ".py", ".proto", ".sh")):
                yield Violation(path, number, "is indented by a tab; use blanks")
        if not text.endswith("\n") or text.endswith("\n\n"):
            yield Violation(path, len(tree.lines(path)), "end the file with exactly one newline")


RULES = (check_markers, check_conflicts, check_machine_paths, check_blanks)
