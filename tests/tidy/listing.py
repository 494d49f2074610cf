"""Every source is built or included, every folder has a README.md, every link works."""

import fnmatch
import posixpath
import re

from includes import includes_of
from source_tree import Violation


def _cmake_mentions(tree):
    """For each folder with a CMakeLists.txt, the words of that file without its comments."""
    mentions = {}
    for path in tree.paths:
        if posixpath.basename(path) == "CMakeLists.txt" or path.endswith(".cmake"):
            text = re.sub(r"#[^\n]*", "", tree.text(path))
            words = set(re.split(r"[\s()\";]+", text))
            mentions.setdefault(posixpath.dirname(path), set()).update(words)
    return mentions


def _is_listed(path, mentions):
    """Whether a CMakeLists.txt in the folder of `path` or above names it by relative path, or one
    in its folder by a pattern."""
    folder, name = posixpath.split(path)
    if any("*" in word and fnmatch.fnmatch(name, word) for word in mentions.get(folder, ())):
        return True
    while True:
        relative = posixpath.relpath(path, folder or ".")
        words = mentions.get(folder, ())
        # A variable may stand for the beginning of the path, as in ${CMAKE_CURRENT_SOURCE_DIR}/x.
        if relative in words or any(word.endswith("}/" + relative) for word in words):
            return True
        if not folder:
            return False
        folder = posixpath.dirname(folder)


def check_sources_are_built(tree):
    """Every .cc and .proto is named in a CMakeLists.txt."""
    mentions = _cmake_mentions(tree)
    for path in tree.with_suffix(".cc", ".proto"):
        if not _is_listed(path, mentions):
            yield Violation(path, 1, "is in no CMakeLists.txt; add it to a target or remove it")


def check_headers_are_included(tree):
    """Every header is included by some other file."""
    included = set()
    for path in tree.with_suffix(".h", ".cc", ".c"):
        for _, name in includes_of(tree, path):
            relative = posixpath.normpath(posixpath.join(posixpath.dirname(path), name))
            if path not in (name, relative):
                included.update((name, relative))
    for path in tree.with_suffix(".h"):
        if path not in included:
            yield Violation(path, 1, "is included by no file; remove it or use it")


def check_python_is_used(tree):
    """Every Python file is run (listed in CMake, executable by a shebang) or imported."""
    mentions = _cmake_mentions(tree)
    imported = set()
    for path in tree.with_suffix(".py"):
        for _, line in tree.lines(path):
            match = re.match(r"\s*(?:from|import)\s+([\w.]+)(?:\s+import\s+(.+))?", line)
            if match:
                imported.update(match.group(1).split("."))
                imported.update(re.findall(r"\w+", match.group(2) or ""))
    for path in tree.with_suffix(".py"):
        stem = posixpath.splitext(posixpath.basename(path))[0]
        runs = tree.text(path).startswith("#!") or stem in ("__init__", "__main__", "setup",
                                                            "conftest")
        if not runs and stem not in imported and not _is_listed(path, mentions):
            yield Violation(path, 1, "is not imported, in no CMakeLists.txt and without a '#!' "
                                     "line; use it or remove it")


# A folder with such a file needs a README.md; data (pictures, recordings) does not.
_SOURCES = (".h", ".cc", ".py", ".sh", ".proto", ".js", ".yaml", ".yml",
            "CMakeLists.txt", "Dockerfile")
# Test folders that mirror the tree need none.
_MIRROR = re.compile(r"tests/(envcore|server|clients|proto|deploy|docs|tools)(/|$)")


def check_readmes(tree):
    """A folder with sources has a README.md that describes it."""
    folders = {posixpath.dirname(path) for path in tree.with_suffix(*_SOURCES)}
    for folder in sorted(folders):
        hidden = folder.startswith(".") or "/." in folder
        readme = posixpath.join(folder, "README.md")
        if not hidden and not _MIRROR.match(folder) and readme not in tree.paths:
            yield Violation(readme, 1, "is missing; describe what the folder is for, how it works "
                                       "and why")
        elif readme in tree.paths and len(tree.text(readme).split()) < 20:
            yield Violation(readme, 1, "has fewer than 20 words; describe what the folder is for, "
                                       "how it works and why")


_LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)\s]*)?\)")


def check_links(tree):
    """The target of a relative link in a Markdown file exists."""
    known = set(tree.paths) | set(tree.folders)
    for path in tree.with_suffix(".md"):
        for number, line in tree.lines(path):
            for target in _LINK.findall(line):
                resolved = posixpath.normpath(posixpath.join(posixpath.dirname(path), target))
                if "://" not in target and not target.startswith("mailto:") and \
                        resolved not in known and resolved != ".":
                    yield Violation(path, number, f"links to {target}, which does not exist")


RULES = (check_sources_are_built, check_headers_are_included, check_python_is_used, check_readmes,
         check_links)
