"""Text that must not be published: markers, merge conflicts, local paths; white space."""

import re

from source_tree import Violation

# Files with text from other projects.
_THIRD_PARTY = ("LICENSE",)

# Split so that this file does not report itself.
_MARKER = re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X|HA" r"CK)\b")
# Paths of a developer's machine.
_LOCAL_PATH = re.compile(r"(?<![\w.~$}])/(work|ro" r"ot|home/\w+|Users/\w+|mnt/\w+)/\w"
                           r"|\b[A-Z]:\\Users\\")


def _text_lines(tree):
    for path in tree.paths:
        if path not in _THIRD_PARTY:
            for number, line in tree.lines(path):
                yield path, number, line


def check_markers(tree):
    """No file contains a marker of unfinished work."""
    for path, number, line in _text_lines(tree):
        match = _MARKER.search(line)
        if match:
            yield Violation(path, number, f"{match.group(1)} marks unfinished work; finish it "
                                          "or open an issue")


# "=======" underlines headings in Markdown, so it does not count.
_CONFLICT = re.compile(r"(<{7}|>{7}|\|{7})( |$)")


def check_conflicts(tree):
    """No file contains merge conflict markers."""
    for path, number, line in _text_lines(tree):
        if _CONFLICT.match(line):
            yield Violation(path, number, "is a conflict marker; finish the merge")


def check_local_paths(tree):
    """No file contains a path of a developer's machine."""
    for path, number, line in _text_lines(tree):
        match = _LOCAL_PATH.search(line)
        if match:
            yield Violation(path, number, f"'{match.group()}...' is a local path; make it relative "
                                          "or an option")


def check_blanks(tree):
    """No trailing blanks, no tabs in sources, exactly one newline at the end of a file."""
    for path in tree.paths:
        text = tree.text(path)
        if path in _THIRD_PARTY or not text:
            continue
        for number, line in tree.lines(path):
            if line != line.rstrip():
                yield Violation(path, number, "ends with a blank; remove it")
            elif line.startswith("\t") and path.endswith((".h", ".cc", ".py", ".proto", ".sh")):
                yield Violation(path, number, "is indented by a tab; use blanks")
        if not text.endswith("\n") or text.endswith("\n\n"):
            yield Violation(path, len(tree.lines(path)), "end the file with exactly one newline")


RULES = (check_markers, check_conflicts, check_local_paths, check_blanks)
