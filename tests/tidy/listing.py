"""Every source is built or included, every folder has a README.md, every link works."""

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
    """Whether a CMakeLists.txt in the folder of `path` or above names it by relative path."""
    folder = posixpath.dirname(path)
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
            yield Violation(path, 1, "no CMakeLists.txt names it; add it to a target or remove it")


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
            yield Violation(path, 1, "no file includes it; remove it or use it")


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
            yield Violation(path, 1, "no file imports it, no CMakeLists.txt names it and it has no "
                                     "'#!' line; use it or remove it")


# A folder that holds such a file wants explaining; data (pictures, recordings) does not.
_EXPLAINED = (".h", ".cc", ".py", ".sh", ".proto", ".js", ".yaml", ".yml",
              "CMakeLists.txt", "Dockerfile")
# Under tests, what mirrors the tree is explained by what it mirrors.
_MIRROR = re.compile(r"tests/(envcore|server|clients|proto|deploy|tools)(/|$)")


def check_readmes(tree):
    """A folder with sources has a README.md that says what it is."""
    needing = {posixpath.dirname(path) for path in tree.with_suffix(*_EXPLAINED)}
    for folder in sorted(needing):
        hidden = folder.startswith(".") or "/." in folder
        readme = posixpath.join(folder, "README.md")
        if not hidden and not _MIRROR.match(folder) and readme not in tree.paths:
            yield Violation(readme, 1, "is missing; say what this folder is, where things are and "
                                       "why it is so")
        elif readme in tree.paths and len(tree.text(readme).split()) < 20:
            yield Violation(readme, 1, "says too little; what is this folder, where are things, "
                                       "why is it so?")


_LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)\s]*)?\)")


def check_links(tree):
    """A relative link in a Markdown file leads to a file or folder of ours."""
    known = set(tree.paths) | set(tree.folders)
    for path in tree.with_suffix(".md"):
        for number, line in tree.lines(path):
            for target in _LINK.findall(line):
                place = posixpath.normpath(posixpath.join(posixpath.dirname(path), target))
                if "://" not in target and not target.startswith("mailto:") and place not in known \
                        and place != ".":
                    yield Violation(path, number, f"links to {target}, which is not there")


RULES = (check_sources_are_built, check_headers_are_included, check_python_is_used, check_readmes,
         check_links)
