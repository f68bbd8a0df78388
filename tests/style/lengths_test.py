#!/usr/bin/env python3
"""lengths.py finds functions where they begin and end, and nothing else.

    python3 tests/style/lengths_test.py
"""

import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import lengths  # noqa: E402


def found(text):
    return [(line, length) for _, line, length in lengths.cpp_functions(text)]


class Functions(unittest.TestCase):
    def test_with_and_without_a_template_line(self):
        self.assertEqual(found("int F(int a) {\n  return a;\n}\n"), [(1, 3)])
        self.assertEqual(found("template <typename T>\nT F(T a) {\n}\n"), [(1, 3)])

    def test_inner_braces_are_part_of_it(self):
        self.assertEqual(
            found("void F() {\n  if (a) {\n  }\n  auto f = [] {\n  };\n}\nint x;\nint G() {\n}"),
            [(1, 6), (8, 2)],
        )

    def test_in_namespaces_and_classes(self):
        text = "namespace a {\nclass B final : public C<int> {\n public:\n  int F() const {\n    return 1;\n  }\n};\n}\n"
        self.assertEqual(found(text), [(4, 3)])

    def test_constructors_with_braces_in_their_initialisers(self):
        text = "A::A(int x)\n    : a_{x},\n      b_(x),\n      c_{x} {\n  F();\n}\nint G() { return 1; }\n"
        self.assertEqual(found(text), [(1, 6), (7, 1)])

    def test_operators(self):
        self.assertEqual(found("A& A::operator=(A&& b) {\n  F();\n}\n"), [(1, 3)])
        self.assertEqual(found("bool operator<(A a, A b) {\n}\n"), [(1, 2)])

    def test_functions_of_structs(self):
        self.assertEqual(found("struct A Make(int x) {\n}\n"), [(1, 2)])
        self.assertEqual(found("struct alignas(16) A {\n  int x;\n};\n"), [])

    def test_values_and_literals_are_none(self):
        self.assertEqual(found("const A kA = Make({\n  1,\n});\nstd::array<int, 2> k{\n1, 2};\n"), [])
        self.assertEqual(found('const char* k = R"css(\nvoid F() {\n)css";\n// void F() {\n'), [])
        self.assertEqual(found("#define F(x) {\nchar c = '{';\nint n = 1'000;\nint m = 2'000;\n"), [])


class Files(unittest.TestCase):
    def test_braces_that_do_not_match_are_told(self):
        for text in ("void F() {", "}"):
            with self.assertRaises(ValueError):
                lengths.cpp_functions(text)

    def test_python(self):
        self.assertEqual(lengths.python_functions("def f():\n    pass\n"), [("f", 1, 2)])


if __name__ == "__main__":
    unittest.main()
