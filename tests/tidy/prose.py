"""Phrases that plain technical English does not need: their count may only fall.

Each of PHRASES has a ceiling in tests/tidy/prose_ceilings.txt, which is its count today. A count
above its ceiling fails, and so does one below it until the ceiling is lowered.
"""

import re

from comments import blocks_of
from source_tree import Violation

CEILINGS = "tests/tidy/prose_ceilings.txt"

# The phrase as its ceiling is called: (what counts, what to write).
PHRASES = {
    "who": (r"who(?:ever)?", "the component: the client, the server, the caller"),
    "tells": (r"tells", "reports, returns, contains or shows"),
    "is told": (r"is told", "receives, or: X reports it to Y"),
    "are told": (r"are told", "receive, or: X reports it to them"),
    "lacks": (r"lacks", "has no, or: without"),
    "anew": (r"anew", "again, or: from the start"),
    "goes on": (r"goes on", "continues"),
    "for ever": (r"for ever", "without limit, indefinitely"),
    "of late": (r"of late", "recently, with the period"),
}
# Between two words of a phrase: blanks, of which one may be the end of a line.
_GAP = r"(?:[ \t]+|[ \t]*\n[ \t]*)"
_PATTERNS = {phrase: re.compile(r"\b" + pattern.replace(" ", _GAP) + r"\b", re.IGNORECASE)
             for phrase, (pattern, _) in PHRASES.items()}


def occurrences(tree):
    """Returns the places of each phrase: pairs of path and line, in order."""
    found = {phrase: [] for phrase in PHRASES}
    for path in tree.paths:
        for block in blocks_of(path, tree.text(path)):
            text = "\n".join(line for _, line in block)
            for phrase, pattern in _PATTERNS.items():
                for match in pattern.finditer(text):
                    line = block[text.count("\n", 0, match.start())][0]
                    found[phrase].append((path, line))
    return found


def _ceilings(tree):
    """For each phrase with a ceiling its line and the number; without the file there are none."""
    ceilings = {}
    for number, line in tree.lines(CEILINGS) if CEILINGS in tree else ():
        phrase, _, count = line.rpartition(" ")
        if count.isdigit():
            ceilings[phrase.strip()] = (number, int(count))
    return ceilings


def check_prose(tree):
    """The count of every phrase equals its ceiling."""
    ceilings = _ceilings(tree)
    for phrase, places in occurrences(tree).items():
        line, ceiling = ceilings.get(phrase, (1, 0))
        count = len(places)
        if count > ceiling:
            yield Violation(CEILINGS, line, f"'{phrase}' occurs {count} times in prose, at most "
                                            f"{ceiling} are allowed; write {PHRASES[phrase][1]} "
                                            "(tests/tidy/tidy.py --prose lists the places)")
        elif count < ceiling:
            yield Violation(CEILINGS, line, f"'{phrase}' occurs {count} times in prose; lower the "
                                            f"ceiling to {count}")


RULES = (check_prose,)
