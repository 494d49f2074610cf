#!/usr/bin/env python3
"""Tests the flags and the closing line of tests/run.sh."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import count_results  # noqa: E402  (after the line above, so that no cache lands in the tree)

_TESTS = pathlib.Path(__file__).resolve().parent


def _run(*arguments):
    return subprocess.run([str(_TESTS / "run.sh"), *arguments], capture_output=True, text=True,
                          check=False, cwd="/")


def _junit(*cases):
    return "<testsuite>" + "".join(cases) + "</testsuite>"


_PASSED = '<testcase name="a" status="run"/>'
_FAILED = '<testcase name="b" status="fail"><failure message=""/></testcase>'
_SKIPPED = ('<testcase name="c" status="notrun">'
            '<skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/></testcase>')
_MISSING = '<testcase name="d" status="notrun"><skipped message="Unable to find it"/></testcase>'


class FlagsTest(unittest.TestCase):
    def test_help_names_every_flag(self):
        result = _run("--help")
        self.assertEqual(result.returncode, 0)
        for flag in ("--preset", "--label", "--all"):
            self.assertIn(flag, result.stdout)

    def test_unknown_flag_is_named(self):
        result = _run("--fast")
        self.assertEqual(result.returncode, 2)
        self.assertIn("'--fast'", result.stderr)

    def test_unknown_preset_error_lists_the_presets(self):
        result = _run("--preset", "debug")
        self.assertEqual(result.returncode, 2)
        self.assertIn("'debug'", result.stderr)
        self.assertIn("dev, release, asan, tsan, lint, fuzz", result.stderr)

    def test_flag_without_its_value_is_an_error(self):
        self.assertIn("--label needs a value", _run("--label").stderr)

    def test_label_is_not_interpreted_as_a_pattern(self):
        self.assertEqual(_run("--label", "unit|slow").returncode, 2)


def _configuration(*arguments):
    """Returns the words with which a copy of run.sh calls cmake first."""
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for path in ("tests/run.sh", "deploy/install-dependencies.sh", "bin/cmake"):
            (root / path).parent.mkdir(exist_ok=True)
            (root / path).write_text("#!/bin/sh\n")
            (root / path).chmod(0o755)
        (root / "tests/run.sh").write_text((_TESTS / "run.sh").read_text())
        (root / "bin/cmake").write_text(f'#!/bin/sh\necho "$@" >{root}/words\nexit 1\n')
        path = f"{root}/bin:{os.environ['PATH']}"
        subprocess.run([root / "tests/run.sh", *arguments], capture_output=True, check=False,
                       env=os.environ | {"PATH": path})
        return (root / "words").read_text().split()


class ConfigurationTest(unittest.TestCase):
    def test_benchmarks_are_built_with_the_slow_tests_only(self):
        flag = "-DPROCGEN_BUILD_BENCHMARKS=ON"
        self.assertNotIn(flag, _configuration())
        self.assertIn(flag, _configuration("--all"))
        self.assertIn(flag, _configuration("--label", "unit", "--label", "slow"))
        self.assertNotIn(flag, _configuration("--all", "--preset", "asan"))


class CountTest(unittest.TestCase):
    def test_each_outcome_goes_to_its_list(self):
        self.assertEqual(count_results.count(_junit(_PASSED, _FAILED, _SKIPPED)),
                         (["a"], ["c"], ["b"]))

    def test_missing_program_counts_as_failed(self):
        self.assertEqual(count_results.count(_junit(_MISSING)), ([], [], ["d"]))

    def test_summary_line_and_exit_status(self):
        for cases, line, status in (((_PASSED, _PASSED), "2 passed, 0 failed", 0),
                                    ((_PASSED, _FAILED), "1 passed, 1 failed", 1),
                                    ((), "0 passed, 0 failed", 1)):
            with tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
                file.write(_junit(*cases))
                file.flush()
                result = subprocess.run(
                    [sys.executable, str(_TESTS / "count_results.py"), file.name],
                    capture_output=True, text=True, check=False)
            self.assertEqual(result.stdout.splitlines()[-1], line)
            self.assertEqual(result.returncode, status)

    def test_failure_of_ctest_itself_is_a_failure(self):
        with tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
            file.write(_junit(_PASSED))
            file.flush()
            result = subprocess.run(
                [sys.executable, str(_TESTS / "count_results.py"), file.name, "--ctest-status=8"],
                capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 1)


if __name__ == "__main__":
    unittest.main()
