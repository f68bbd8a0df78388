#!/usr/bin/env python3
"""No source file over 300 lines and no function over 80 in the named folders.

    python3 tests/style/lengths.py [FOLDER...]    # nn vo weights_tools apps, if none is named

Prints what is too long and exits with 1. A function is what stands in a namespace or a class and
has a body; lambdas count with the function around them.
"""

import ast
import re
import subprocess
import sys

LARGEST_FILE = 300
LARGEST_FUNCTION = 80
SOURCES = (".cc", ".h", ".py", ".sh")

# Comments, literals (raw ones first) and preprocessor lines: none of them opens a function.
NOT_CODE = re.compile(
    r"""//[^\n]*|/\*.*?\*/
    |R"(?P<delimiter>[^()\s\\]{0,16})\(.*?\)(?P=delimiter)"
    |"(?:\\.|[^"\\\n])*"
    |(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'
    |^[ \t]*\#(?:\\\n|[^\n])*""",
    re.DOTALL | re.VERBOSE | re.MULTILINE,
)


def code_alone(text):
    """The text with everything else blanked, line for line."""
    return NOT_CODE.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def without_brackets(text, opening, closing):
    kept, depth = [], 0
    for character in text:
        depth += character == opening
        if depth == 0:
            kept.append(character)
        depth -= character == closing and depth > 0
    return "".join(kept)


def opens(header):
    """What a brace after this text opens, in a namespace or class: a scope, a function, a value."""
    header = re.sub(r"\boperator\s*[^\s\w(]+|\boperator\s*\(\s*\)", "operator_", header)
    header = re.sub(r"\balignas\s*\([^()]*\)|\[\[.*?\]\]", " ", header)
    has_parameters = "(" in header
    header = without_brackets(header, "(", ")")
    header = re.sub(r"[<>]=|[=!]=|->|<<|>>=", " ", header)
    header = without_brackets(header, "<", ">")
    if "=" in header:
        return "value"
    if re.search(r"\b(namespace|enum|extern)\b", header):
        return "scope"
    if re.match(r"\s*(template\s*)?(typedef\s+)?(class|struct|union)\b", header):
        return "function" if has_parameters and re.search(r"\w\s+\w+\s*$", header) else "scope"
    return "function" if has_parameters else "value"


def cpp_functions(text):
    """(name, first line, number of lines) of each function."""
    code = code_alone(text)
    scopes = []  # What each open brace opened, and where its header starts.
    header_start = 0
    last_function = None  # Its header's start and its end: `: a_{1}, b_{2} {` has several braces.
    found = {}
    for position, character in enumerate(code):
        inside = bool(scopes) and scopes[-1][0] != "scope"
        if character == "{":
            header = code[header_start:position]
            kind, start = "block", header_start
            if not inside:
                kind = opens(header)
                if last_function is not None and re.match(r"\s*(,|$)", header):
                    kind, start = "function", last_function
                elif kind == "function":
                    start += len(header) - len(header.lstrip())
            scopes.append((kind, start))
            header_start = position + 1
        elif character == "}":
            if not scopes:
                raise ValueError("a brace closes that none opened")
            kind, start = scopes.pop()
            if kind == "function":
                first = code.count("\n", 0, start) + 1
                name = " ".join(code[start:].split("(")[0].split())
                found[first] = (name, first, code.count("\n", 0, position) + 2 - first)
            if kind != "block":
                last_function = start if kind == "function" else None
                header_start = position + 1
        elif character == ";" and not inside:
            header_start, last_function = position + 1, None
        elif character == ":" and not inside:
            header = code[header_start:position]
            if re.fullmatch(r"\s*(public|private|protected)\s*", header):
                header_start = position + 1
    if scopes:
        raise ValueError("a brace opens that none closes")
    return list(found.values())


def python_functions(text):
    return [
        (node.name, node.lineno, node.end_lineno - node.lineno + 1)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
    ]


def check(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    lines = text.count("\n")
    if lines > LARGEST_FILE:
        yield f"{path}: {lines} lines, {LARGEST_FILE} are allowed"
    functions = []
    if path.endswith((".cc", ".h")):
        functions = cpp_functions(text)
    elif path.endswith(".py"):
        functions = python_functions(text)
    for name, line, length in functions:
        if length > LARGEST_FUNCTION:
            yield f"{path}:{line}: {name} has {length} lines, {LARGEST_FUNCTION} are allowed"


def main():
    folders = sys.argv[1:] or ["nn", "vo", "weights_tools", "apps"]
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--", *folders], check=True, capture_output=True, text=True
    ).stdout
    paths = [path for path in listed.split("\0") if path.endswith(SOURCES)]
    if not paths:
        sys.exit(f"no sources in {', '.join(folders)}")
    too_long = []
    for path in paths:
        try:
            too_long += check(path)
        except FileNotFoundError:
            continue  # Deleted, and not yet so for git.
        except (ValueError, SyntaxError) as error:
            too_long.append(f"{path}: {error}")
    print("\n".join(too_long + [f"{len(paths)} files, {len(too_long)} findings"]))
    return 1 if too_long else 0


if __name__ == "__main__":
    sys.exit(main())
