#!/usr/bin/env python3
"""Checks the repository rules over all files of the repository and reports every violation.

Usage: tests/tidy/tidy.py [ROOT]. Prints path:line: the violation and its remedy.
Exit status: 0 without violations, otherwise 1.
"""

import fnmatch
import pathlib
import sys

sys.dont_write_bytecode = True  # Set before the imports below: no caches in the tree.
import exceptions  # noqa: E402
import includes  # noqa: E402
import listing  # noqa: E402
import names  # noqa: E402
import sizes  # noqa: E402
import source_tree  # noqa: E402
import traces  # noqa: E402

RULES = includes.RULES + names.RULES + sizes.RULES + listing.RULES + traces.RULES


def check(tree, rules=RULES, excepted=exceptions.EXCEPTIONS):
    """Returns sorted pairs (violation, name of the rule); exceptions without a violation, too."""
    found, used = [], set()
    for rule in rules:
        for violation in rule(tree):
            exception = next((entry for entry in excepted
                              if entry[0] == rule.__name__
                              and fnmatch.fnmatchcase(violation.path, entry[1])), None)
            if exception:
                used.add(exception)
            else:
                found.append((violation, rule.__name__))
    for entry in excepted:
        folder = entry[1].rsplit("/", 1)[0]
        exists = any(fnmatch.fnmatchcase(path, entry[1]) or path.startswith(folder + "/")
                     for path in tree.paths)
        if exists and entry not in used:
            violation = source_tree.Violation("tests/tidy/exceptions.py", 1,
                                              f"{entry[:2]} matches no violation; remove it")
            found.append((violation, "exceptions"))
    return sorted(found)


def main(arguments):
    root = pathlib.Path(arguments[0]) if arguments else pathlib.Path(__file__).parents[2]
    tree = source_tree.SourceTree.read(root.resolve())
    found = check(tree)
    for violation, rule in found:
        print(f"{violation} [{rule}]")
    print(f"{len(tree.paths)} files, {len(RULES)} rules, {len(found)} violations")
    return 1 if found or not tree.paths else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
