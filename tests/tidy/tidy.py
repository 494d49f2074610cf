#!/usr/bin/env python3
"""Checks the repository rules over all files of the repository and reports every violation.

Usage: tests/tidy/tidy.py [--prose] [ROOT]. Prints path:line: what is wrong and what to do about it.
Exit status: 0 if nothing is wrong, otherwise 1. --prose: instead prints the places of
the phrases that prose.py counts; exit status 0.
"""

import fnmatch
import pathlib
import sys

sys.dont_write_bytecode = True
# The line above keeps caches out of the tree, so it stands before our own modules.
import exceptions  # noqa: E402
import includes  # noqa: E402
import listing  # noqa: E402
import names  # noqa: E402
import prose  # noqa: E402
import retired  # noqa: E402
import sizes  # noqa: E402
import source_tree  # noqa: E402
import traces  # noqa: E402

RULES = (includes.RULES + names.RULES + sizes.RULES + listing.RULES + traces.RULES
         + prose.RULES + retired.RULES)


def check(tree, rules=RULES, excused=exceptions.EXCEPTIONS):
    """Returns all violations as sorted (violation, name of the rule)."""
    found, used = [], set()
    for rule in rules:
        for violation in rule(tree):
            excuse = next((entry for entry in excused
                           if entry[0] == rule.__name__
                           and fnmatch.fnmatchcase(violation.path, entry[1])), None)
            if excuse:
                used.add(excuse)
            else:
                found.append((violation, rule.__name__))
    for entry in excused:
        folder = entry[1].rsplit("/", 1)[0]
        is_there = any(fnmatch.fnmatchcase(path, entry[1]) or path.startswith(folder + "/")
                       for path in tree.paths)
        if is_there and entry not in used:
            violation = source_tree.Violation("tests/tidy/exceptions.py", 1,
                                              f"{entry[:2]} excuses nothing; remove it")
            found.append((violation, "exceptions"))
    return sorted(found)


def list_prose(tree):
    """Prints every place of every counted phrase, and the counts."""
    found = prose.occurrences(tree)
    for phrase, places in found.items():
        for path, line in places:
            print(f"{path}:{line}: {phrase}")
    for phrase, places in found.items():
        print(phrase, len(places))


def main(arguments):
    shows_prose = "--prose" in arguments
    arguments = [argument for argument in arguments if argument != "--prose"]
    root = pathlib.Path(arguments[0]) if arguments else pathlib.Path(__file__).parents[2]
    tree = source_tree.SourceTree.read(root.resolve())
    if shows_prose:
        list_prose(tree)
        return 0
    found = check(tree)
    for violation, rule in found:
        print(f"{violation} [{rule}]")
    print(f"{len(tree.paths)} files, {len(RULES)} rules, {len(found)} violations")
    return 1 if found or not tree.paths else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
