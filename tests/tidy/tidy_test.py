#!/usr/bin/env python3
"""Proves that every tidy rule can fail, and that it accepts valid input.

Each case is a small made-up repository. A rule without a case fails the test.
"""

import sys
import unittest

sys.dont_write_bytecode = True  # Set before the imports below: no caches in the tree.
import exceptions  # noqa: E402
import includes  # noqa: E402
import listing  # noqa: E402
import names  # noqa: E402
import sizes  # noqa: E402
import tidy  # noqa: E402
import traces  # noqa: E402
from source_tree import SourceTree  # noqa: E402


def _include(*headers):
    return "".join(f'#include "{header}"\n' for header in headers)


def _cpp_function(line_count):
    body = "  Use(Braces{1}, '{', \"{\");  // {\n" * (line_count - 2)
    return "namespace procgen {\nvoid Play(int x) {\n" + body + "}\n}  // namespace procgen\n"


_README = "# Grid\n" + "What this is, where things are in it and why it is so. " * 3 + "\n"
_MARK = "TO" + "DO"

# For each rule: pairs of a tree that breaks it and the reported place.
_BROKEN = {
    includes.check_include_directions: (
        ({"envcore/world/grid.h": _include("envcore/level/maze.h")}, "envcore/world/grid.h:1"),
        ({"envcore/render/raster/x.cc": _include("envcore/games/game.h")},
         "envcore/render/raster/x.cc:1"),
        ({"envcore/games/maze.cc": _include("envcore/render/raster/x.h")},
         "envcore/games/maze.cc:1"),
        ({"envcore/render/raster/x.cc": _include("envcore/render/scene/y.h")},
         "envcore/render/raster/x.cc:1"),
        ({"server/rpc/x.cc": _include("envcore/games/game.h")}, "server/rpc/x.cc:1"),
        ({"server/pool/x.cc": "\n" + _include("server/rpc/y.h")}, "server/pool/x.cc:2"),
        ({"clients/cpp/x.cc": _include("envcore/games/game.h")}, "clients/cpp/x.cc:1"),
        ({"clients/cpp/x.cc": _include("clients/libenv/y.h")}, "clients/cpp/x.cc:1"),
        ({"server/rpc/x.cc": _include("procgen_client/y.h"), "clients/cpp/procgen_client/y.h": ""},
         "server/rpc/x.cc:1"),
        ({"envcore/pool/x.cc": _include("server/pool/y.h")}, "envcore/pool/x.cc:1"),
        ({"envcore/pool/x.cc": _include("tests/envcore/y.h")}, "envcore/pool/x.cc:1"),
        ({"elsewhere/x.cc": "int x;\n"}, "elsewhere/x.cc:1"),
    ),
    includes.check_guarded_headers: (
        ({"server/pool/x.cc": _include("grpcpp/grpcpp.h")}, "server/pool/x.cc:1"),
        ({"server/pool/x.cc": _include("procgen/v1/step.grpc.pb.h")}, "server/pool/x.cc:1"),
        ({"server/pool/x.cc": _include("procgen/v1/step.pb.h")}, "server/pool/x.cc:1"),
        ({"server/wire/x.cc": "#include <dds/dds.h>\n"}, "server/wire/x.cc:1"),
    ),
    includes.check_engine_purity: (
        ({"envcore/games/maze.cc": "#include <chrono>\n"}, "envcore/games/maze.cc:1"),
        ({"envcore/pool/pool.cc": _include("absl/time/clock.h")}, "envcore/pool/pool.cc:1"),
        ({"envcore/render/x.cc": "#include <thread>\n"}, "envcore/render/x.cc:1"),
    ),
    includes.check_link_directions: (
        ({"envcore/world/CMakeLists.txt": "\ntarget_link_libraries(w PUBLIC procgen::level)\n"},
         "envcore/world/CMakeLists.txt:2"),
        ({"clients/cpp/CMakeLists.txt": "target_link_libraries(c PRIVATE procgen::games)\n"},
         "clients/cpp/CMakeLists.txt:1"),
        ({"server/rpc/CMakeLists.txt": "target_link_libraries(r\n  PUBLIC procgen::games)\n"},
         "server/rpc/CMakeLists.txt:1"),
    ),
    names.check_file_names: (
        ({"envcore/world/grid_utils.h": ""}, "envcore/world/grid_utils.h:1"),
        ({"server/common/x.h": ""}, "server/common:1"),
    ),
    names.check_declared_names: (
        ({"envcore/world/x.h": "\nclass GridManager {\n"}, "envcore/world/x.h:2"),
        ({"clients/python/x.py": "def misc():\n    pass\n"}, "clients/python/x.py:1"),
        ({"proto/x.proto": "message StepStuff {}\n"}, "proto/x.proto:1"),
        ({"CMakeLists.txt": "add_library(procgen_util x.cc)\n"}, "CMakeLists.txt:1"),
    ),
    names.check_header_guards: (
        ({"envcore/world/grid.h": "#ifndef GRID_H\n#define GRID_H\n#endif\n"},
         "envcore/world/grid.h:1"),
        ({"a/b.h": "#ifndef A_B_H_\n#define A_B_H_\nint x;\n#endif\n"}, "a/b.h:4"),
        ({"a/b.h": "#pragma once\n"}, "a/b.h:1"),
    ),
    sizes.check_line_length: (
        ({"x.cc": "\n" + "x" * 101 + "\n"}, "x.cc:2"),
        ({"x.py": "x" * 101 + "\n"}, "x.py:1"),
    ),
    sizes.check_file_length: (({"x.cc": "\n" * 501}, "x.cc:501"),),
    sizes.check_python_function_length: (
        ({"x.py": "\ndef play():\n" + "    go()\n" * 70}, "x.py:2"),
        ({"x.py": "def play(:\n"}, "x.py:1"),
    ),
    sizes.check_cpp_function_length: (({"x.cc": _cpp_function(71)}, "x.cc:2"),),
    listing.check_sources_are_built: (
        ({"a/x.cc": "", "a/CMakeLists.txt": "add_library(a y.cc)  # not x.cc\n"}, "a/x.cc:1"),
        ({"proto/x.proto": "", "CMakeLists.txt": ""}, "proto/x.proto:1"),
        ({"a/b/x.cc": "", "a/CMakeLists.txt": "file(GLOB files *.cc)\n"}, "a/b/x.cc:1"),
    ),
    listing.check_headers_are_included: (
        ({"a/x.h": "", "a/y.cc": _include("b/x.h")}, "a/x.h:1"),
        ({"a/x.h": _include("a/x.h")}, "a/x.h:1"),
    ),
    listing.check_python_is_used: (
        ({"a/x.py": "pass\n", "a/y.py": "#!/x\nimport z\n"}, "a/x.py:1"),
    ),
    listing.check_readmes: (
        ({"a/x.cc": ""}, "a/README.md:1"),
        ({"a/x.cc": "", "a/README.md": "# A\n"}, "a/README.md:1"),
    ),
    listing.check_links: (({"a/README.md": "\nsee [b](../b.md)\n"}, "a/README.md:2"),),
    traces.check_markers: (({"x.sh": f"\n# {_MARK}: more\n"}, "x.sh:2"),),
    traces.check_conflicts: (
        ({"CMakeLists.txt": "add(x)\n=======\nadd(y)\n" + ">" * 7 + " d9b092e\n"},
         "CMakeLists.txt:4"),
    ),
    traces.check_local_paths: (
        ({"x.md": "cd /ho" + "me/ada/procgen\n"}, "x.md:1"),
        ({"x.sh": "cd /wo" + "rk/main\n"}, "x.sh:1"),
    ),
    traces.check_blanks: (
        ({"x.md": "a \n"}, "x.md:1"),
        ({"x.cc": "\tint x;\n"}, "x.cc:1"),
        ({"x.md": "a"}, "x.md:1"),
        ({"x.md": "a\n\n"}, "x.md:2"),
    ),
}

# For each rule: trees that keep it.
_KEPT = {
    includes.check_include_directions: (
        {"envcore/pool/pool.cc": _include("envcore/random/random_stream.h", "absl/status/status.h",
                                          "envcore/pool/pool.h", "envcore/games/game_catalog.h")},
        {"server/main.cc": _include("server/rpc/server.h", "envcore/pool/pool.h")},
        {"clients/libenv/libenv.cc": _include("envcore/pool/pool.h", "procgen_client/client.h"),
         "clients/cpp/procgen_client/client.h": ""},
        {"clients/cpp/client.cc": _include("clients/cpp/client.h")},
        {"tests/server/rpc/x_test.cc": _include("envcore/games/game.h", "tests/server/y.h")},
    ),
    includes.check_guarded_headers: (
        {"server/rpc/x.cc": _include("grpcpp/grpcpp.h", "procgen/v1/step.grpc.pb.h")},
        {"clients/cpp/x.cc": _include("grpcpp/grpcpp.h")},
        {"server/cluster/x.cc": _include("dds/dds.h")},
    ),
    includes.check_engine_purity: (
        {"envcore/pool/worker_pool.cc": "#include <thread>\n"},
        {"server/pool/x.cc": "#include <chrono>\n"},
    ),
    includes.check_link_directions: (
        {"envcore/world/CMakeLists.txt": "target_link_libraries(w PUBLIC procgen::random)\n"},
        {"clients/libenv/CMakeLists.txt": "target_link_libraries(c PRIVATE procgen::pool)\n"},
        {"tests/CMakeLists.txt": "target_link_libraries(t PRIVATE procgen::games)\n"},
    ),
    names.check_file_names: ({"server/communal_request_handler.cc": ""},),
    names.check_declared_names: ({"x.cc": "class DataProcessor {\n  // a common helper\n"},),
    names.check_header_guards: (
        {"clients/cpp/p/x.h": "#ifndef P_X_H_\n#define P_X_H_\n\n#endif  // P_X_H_\n"},
        {"a/b_c.h": "// Licence.\n#ifndef A_B_C_H_\n#define A_B_C_H_\n\n#endif  // A_B_C_H_\n"},
    ),
    sizes.check_line_length: ({"x.cc": "x" * 100 + "\n", "y.md": "x" * 200 + "\n"},),
    sizes.check_file_length: ({"x.cc": "\n" * 500, "x.trace": "\n" * 600},),
    sizes.check_python_function_length: ({"x.py": "def play():\n" + "    go()\n" * 69},),
    sizes.check_cpp_function_length: (
        {"x.cc": _cpp_function(70)},
        {"x.cc": "constexpr Facts kFacts[] = {\n" + "    {.name = 1},\n" * 90 + "};\n"},
        {"x.h": "class Pool : public Base<int()> {\n" + "  void Step() { go(); }\n" * 90 + "};\n"},
        {"tests/x_test.cc": _cpp_function(90)},
    ),
    listing.check_sources_are_built: (
        {"a/x.cc": "", "a/b/y.cc": "", "a/CMakeLists.txt": "add_library(a x.cc b/y.cc)\n"},
        {"a/x.proto": "", "CMakeLists.txt": "set(FILES ${PROJECT_SOURCE_DIR}/a/x.proto)\n"},
        {"a/x.cc": "", "a/CMakeLists.txt": "file(GLOB files *.cc)\n"},
    ),
    listing.check_headers_are_included: (
        {"a/x.h": "", "a/x.cc": _include("a/x.h")},
        {"a/x.h": "", "a/x.cc": _include("x.h")},
        {"clients/cpp/p/x.h": "", "a/x.cc": _include("p/x.h")},
    ),
    listing.check_python_is_used: (
        {"a/x.py": "pass\n", "a/y.py": "#!/usr/bin/env python3\nfrom a import x\n"},
    ),
    listing.check_readmes: (
        {"a/x.cc": "", "a/README.md": _README, "tests/envcore/x.cc": "", "art/x.svg": ""},
    ),
    listing.check_links: (
        {"a/README.md": "[c](../b/c.md#top) [b](../b) [web](https://x.org/y)\n", "b/c.md": ""},
    ),
    traces.check_markers: ({"x.md": "The list of what to do; a todo list.\n"},),
    traces.check_conflicts: ({"x.md": "Title\n=======\n>>> print(1)\n"},),
    traces.check_local_paths: (
        {"x.sh": "#!/usr/bin/env bash\ncd $HOME/work/x\n# rest at/work/ing\n"},
    ),
    traces.check_blanks: ({"x.md": "a\n\nb\n", "Makefile": "\tx\n"},),
}


class RulesTest(unittest.TestCase):
    def test_every_rule_can_fail(self):
        for rule in tidy.RULES:
            with self.subTest(rule=rule.__name__):
                self.assertIn(rule, _BROKEN, "add a tree that breaks the rule")
                for texts, place in _BROKEN[rule]:
                    found = [f"{violation.path}:{violation.line}"
                             for violation in rule(SourceTree(texts))]
                    self.assertEqual(found, [place], texts)

    def test_no_rule_rejects_valid_input(self):
        for rule in tidy.RULES:
            with self.subTest(rule=rule.__name__):
                self.assertIn(rule, _KEPT, "add a tree that keeps the rule")
                for texts in _KEPT[rule]:
                    self.assertEqual(list(rule(SourceTree(texts))), [], texts)

    def test_allowed_includes_have_no_cycle(self):
        def reach(module, seen):
            self.assertNotIn(module, seen)
            for target in includes.DEPENDENCIES[module]:
                reach(target, (*seen, module))
        for module in includes.DEPENDENCIES:
            reach(module, ())


class ExceptionsTest(unittest.TestCase):
    def test_an_exception_applies_to_its_rule_and_path_only(self):
        tree = SourceTree({"a/x.cc": "y" * 101 + "\n", "b/x.cc": "y" * 101 + "\n"})
        excepted = (("check_line_length", "a/*", "because"),)
        found = tidy.check(tree, (sizes.check_line_length,), excepted)
        self.assertEqual([violation.path for violation, _ in found], ["b/x.cc"])

    def test_an_exception_without_a_violation_is_reported(self):
        tree = SourceTree({"a/x.cc": "y\n"})
        excepted = (("check_line_length", "a/*", "because"),)
        found = tidy.check(tree, (sizes.check_line_length,), excepted)
        self.assertIn("matches no violation", str(found[0][0]))

    def test_every_exception_names_a_rule_and_has_a_reason(self):
        known = {rule.__name__ for rule in tidy.RULES}
        for rule, _, reason in exceptions.EXCEPTIONS:
            self.assertIn(rule, known)
            self.assertGreater(len(reason.split()), 3)


if __name__ == "__main__":
    unittest.main()
