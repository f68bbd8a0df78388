"""From the names of changed files on the standard input to the .cc files that clang-tidy has to
read for them: those that changed, and for each header that changed up to three that include it,
through other headers where no .cc does so itself.
"""

import os
import re
import subprocess
import sys

INCLUDERS = 3
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def includers_of(header, includes):
    """The .cc files nearest to the header, its own first."""
    seen, level = {header}, [header]
    while level:
        level = [
            path
            for path, names in includes.items()
            if path not in seen
            and any(("/" + target).endswith("/" + name) for name in names for target in level)
        ]
        seen.update(level)
        sources = [path for path in level if path.endswith(".cc")]
        if sources:
            stem = os.path.splitext(os.path.basename(header))[0]
            return sorted(sources, key=lambda p: (os.path.basename(p) != stem + ".cc", p))[:INCLUDERS]
    return []


def main():
    listed = subprocess.run(
        ["git", "ls-files", "-z", "*.cc", "*.h"], check=True, capture_output=True, text=True
    ).stdout
    paths = [path for path in listed.split("\0") if os.path.exists(path)]
    includes = {}
    for path in paths:
        with open(path, encoding="utf-8") as file:
            includes[path] = INCLUDE.findall(file.read())
    affected = set()
    for path in set(sys.stdin.read().split("\n")) & set(paths):
        affected.update([path] if path.endswith(".cc") else includers_of(path, includes))
    # Built by presets of their own.
    apart = ("tests/fuzz/", "tests/install/")
    print("".join(f"{path}\n" for path in sorted(affected) if not path.startswith(apart)), end="")


if __name__ == "__main__":
    main()
