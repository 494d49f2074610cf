#!/usr/bin/env python3
"""Counts the tests in a JUnit file that CTest wrote and prints the closing line of tests/run.sh.

Prints the names of the tests that failed, how many skipped themselves, and last, alone on a line,
"N passed, M failed". Exit status: 0 if some test passed and none failed, otherwise 1.
"""

import argparse
import sys
import xml.etree.ElementTree as ElementTree

# CTest's message for a test that skipped itself. Any other reason for not running (a missing
# program, a failed fixture) counts as a failure.
_SKIP_MARKS = ("SKIP_REGULAR_EXPRESSION_MATCHED", "SKIP_RETURN_CODE")


def count(junit_text):
    """Returns (passed, skipped, failed), each a list of names."""
    passed, skipped, failed = [], [], []
    for case in ElementTree.fromstring(junit_text).iter("testcase"):
        name, status = case.get("name", "?"), case.get("status")
        reason = case.find("skipped")
        reason = "" if reason is None else reason.get("message", "")
        if status == "run":
            passed.append(name)
        elif status == "disabled" or (status == "notrun" and reason.startswith(_SKIP_MARKS)):
            skipped.append(name)
        else:
            failed.append(name)
    return passed, skipped, failed


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("junit", help="the file that ctest --output-junit wrote")
    parser.add_argument("--ctest-status", type=int, default=0, help="exit status of ctest")
    arguments = parser.parse_args()
    try:
        with open(arguments.junit, encoding="utf-8") as file:
            passed, skipped, failed = count(file.read())
    except (OSError, ElementTree.ParseError) as error:
        print(f"No results: {error}", file=sys.stderr)
        passed, skipped, failed = [], [], []
    print()
    for name in failed:
        print(f"FAILED: {name}")
    for name in skipped:
        print(f"skipped: {name}")
    if not passed and not failed:
        print("No test ran.")
    elif arguments.ctest_status != 0 and not failed:
        print(f"ctest ended with status {arguments.ctest_status}.")
    print(f"{len(passed)} passed, {len(failed)} failed", flush=True)
    return 0 if passed and not failed and arguments.ctest_status == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
