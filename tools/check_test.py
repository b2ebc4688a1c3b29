#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# Tests that each check finds its fault in a small tree, and finds none in a good one.
import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import check
import check_layers
import check_text

LAYERS = """layer 0 base math
layer 1 tile kernel
layer 5 technique
allow math base
third_party fmt/ *
third_party gdal tile
"""
HEAD = "// SPDX-License-Identifier: Apache-2.0\n// A file of this test.\n"


class TreeTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.write("layers.txt", LAYERS)
        self.build = self.root / "build"
        self.write("build/compile_commands.json", json.dumps([
            {"file": str(self.root / "src/base/a.cpp"), "directory": str(self.root),
             "command": f"g++ -std=c++20 -I{self.root}/src -c {self.root}/src/base/a.cpp"}]))

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def include(self, name, header):
        """Faults of a tree with one file that includes one header."""
        self.write(name, f"{HEAD}#include {header}\n")
        return check_layers.check(self.root)


class Layers(TreeTest):
    def test_downward_and_own_room_are_allowed(self):
        self.assertEqual(self.include("src/kernel/a.cpp", '"base/log.h"'), [])
        self.assertEqual(self.include("src/kernel/a.cpp", '"kernel/leaf/leaf.h"'), [])
        self.assertEqual(self.include("src/math/a.cpp", '"base/log.h"'), [])
        self.assertEqual(self.include("src/kernel/a.cpp", '"terray/result.h"'), [])
        self.assertEqual(self.include("src/kernel/a.cpp", "<vector>"), [])

    def test_upward_and_sideways_are_faults(self):
        faults = self.include("src/base/a.cpp", '"kernel/trace.h"')
        self.assertEqual(len(faults), 1)
        self.assertIn('src/base/a.cpp:3: #include "kernel/trace.h"', faults[0])
        self.assertTrue(self.include("src/base/a.cpp", '"math/types.h"'))
        self.assertTrue(self.include("src/tile/a.cpp", '"kernel/trace.h"'))

    def test_techniques_do_not_include_one_another(self):
        own, other = '"technique/ray_cast/a.h"', '"technique/tile_cast/a.h"'
        self.assertEqual(self.include("src/technique/ray_cast/a.cpp", own), [])
        self.assertTrue(self.include("src/technique/ray_cast/a.cpp", other))

    def test_tests_may_look_up(self):
        self.assertEqual(self.include("src/base/a_test.cpp", '"kernel/trace.h"'), [])

    def test_third_party_headers_stay_in_their_rooms(self):
        self.assertEqual(self.include("src/tile/a.cpp", "<gdal.h>"), [])
        self.assertTrue(self.include("src/kernel/a.cpp", "<gdal.h>"))
        self.assertEqual(self.include("src/kernel/a.cpp", '"fmt/format.h"'), [])
        self.assertTrue(self.include("src/kernel/a.cpp", "<unheard/of.h>"))

    def test_public_headers_and_programs_stay_public(self):
        self.assertTrue(self.include("include/terray/a.h", "<fmt/format.h>"))
        self.assertTrue(self.include("include/terray/a.h", '"base/log.h"'))
        self.assertTrue(self.include("apps/cli/a.cpp", '"base/log.h"'))


class Text(TreeTest):
    def faults(self, check_of, name, text):
        self.write(name, text)
        return list(check_of(self.root))

    def test_first_lines(self):
        first = check_text.check_first_lines
        self.assertEqual(self.faults(first, "src/a.cpp", HEAD), [])
        self.assertTrue(self.faults(first, "src/a.cpp", "// A file without a licence.\n"))
        self.assertTrue(self.faults(first, "src/a.cpp", HEAD.splitlines()[0] + "\nint a;\n"))
        self.assertTrue(self.faults(first, "src/a.cpp", HEAD.splitlines()[0] + "\n// Words.\n"))

    def test_long_files_and_functions(self):
        sizes = check_text.check_sizes
        body = "    work();\n"
        self.assertEqual(self.faults(sizes, "src/a.cpp", "void f() {\n" + body * 58 + "}\n"), [])
        long = "struct A {\n    A() : b{1}, c(2) {\n" + body * 59 + "    }\n};\n"
        self.assertIn("A has 61 lines", self.faults(sizes, "src/a.cpp", long)[0])
        self.assertIn("501 lines", self.faults(sizes, "src/a.cpp", "int a;\n" * 501)[0])

    def test_size_exceptions_need_a_reason_and_a_cause(self):
        sizes = check_text.check_sizes
        self.write("src/a.cpp", "int a;\n" * 501)
        self.assertEqual(self.faults(sizes, "tools/size_exceptions.txt", "src/a.cpp: a table\n"), [])
        self.assertTrue(self.faults(sizes, "tools/size_exceptions.txt", "src/a.cpp: \n"))
        self.write("src/a.cpp", "int a;\n")
        self.assertTrue(self.faults(sizes, "tools/size_exceptions.txt", "src/a.cpp: a table\n"))

    def test_forbidden_words(self):
        words = check_text.check_words
        self.assertEqual(self.faults(words, "src/a.cpp", "// The slope (rise over run).\nint a;\n"), [])
        for line in ("// TODO later", "#if 0", "TEST(A, DISABLED_b) {}", "    GTEST_SKIP();",
                     "// a = f(b);", 'open("/home/me/dem.tif");', "// See issue 12.",
                     "// As in paper 000."):
            self.assertTrue(self.faults(words, "src/a.cpp", line + "\n"), line)

    def test_names(self):
        names = check_text.check_names
        good = "class Ray {};\nconstexpr int kMips = 3;\nint width();\n"
        self.assertEqual(self.faults(names, "src/a.cpp", good), [])
        for line in ("struct ray {", "constexpr int mips = 3;", "int getWidth();"):
            self.assertTrue(self.faults(names, "src/a.cpp", line + "\n"), line)
        self.write("src/a.cpp", "")
        self.assertTrue(self.faults(names, "src/TileId.h", ""))

    def test_links_and_readmes(self):
        links = check_text.check_links
        self.assertEqual(self.faults(links, "README.md", "[a](layers.txt) [b](https://a.b/c) [c](#d)\n"), [])
        self.assertTrue(self.faults(links, "README.md", "[a](missing.md)\n"))
        self.assertTrue(self.faults(check_text.check_readmes, "src/base/a.h", HEAD))
        self.assertEqual(self.faults(check_text.check_readmes, "src/base/README.md", "Base.\n"), [])


class Compiled(TreeTest):
    def test_a_change_of_an_included_header_is_seen(self):
        self.write("src/base/b.h", HEAD + "#pragma once\n#include <vector>\n")
        self.write("src/base/a.h", HEAD + '#pragma once\n#include "base/b.h"\nstd::vector<int> f();\n')
        self.assertEqual(check.check_headers(self.root, self.build), [])
        self.write("src/base/b.h", HEAD + "#pragma once\n")
        self.assertTrue(check.check_headers(self.root, self.build))

    def test_headers_compile_alone(self):
        self.write("src/base/a.h", HEAD + "#pragma once\n#include <vector>\nstd::vector<int> f();\n")
        self.assertEqual(check.check_headers(self.root, self.build), [])
        self.write("src/base/a.h", HEAD + "#pragma once\nstd::vector<int> f();\n")
        self.assertTrue(check.check_headers(self.root, self.build))

    def test_format(self):
        self.write(".clang-format", (check.ROOT / ".clang-format").read_text())
        self.write("src/base/a.cpp", HEAD + "int f();\n")
        self.assertEqual(check.check_format(self.root, self.build), [])
        self.write("src/base/a.cpp", HEAD + "int  f( );\n")
        self.assertTrue(check.check_format(self.root, self.build))

    def test_tidy(self):
        self.write(".clang-tidy", (check.ROOT / ".clang-tidy").read_text())
        self.write("src/base/a.cpp", HEAD + "class A {\n    int b_ = 0;\n};\n")
        self.assertEqual(check.tidy_sources(self.root, self.build), [])
        for text in ("class A {\n    int b = 0;\n};\n", "int some_name();\n", "const int mips = 3;\n"):
            self.write("src/base/a.cpp", HEAD + text)
            self.assertTrue(check.tidy_sources(self.root, self.build), text)


if __name__ == "__main__":
    unittest.main()
