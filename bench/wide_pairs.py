#!/usr/bin/env python3
"""How many matches of photographs with known cameras are right, and how that falls with distance.

    bench/wide_pairs.py [--gluevo PROGRAM] [--max-error PX] FOLDER [OPTIONS...]

FOLDER holds images and pairs_with_gt.txt, a line for each pair: name0 name1 rotation0 rotation1 K0
(9 numbers) K1 (9) T_0to1 (16), pixels and metres, as SuperGlue's evaluation takes them. Each of
OPTIONS, in quotes, is what `gluevo match` gets besides the two images: a row of the table. Prints
Markdown: for pairs whose names are so many steps apart in the order of names the share of matches
within --max-error of the true epipolar line, and how many matches a pair has. Needs Python alone.
"""
import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def transposed(a):
    return [list(row) for row in zip(*a)]


def inverse_intrinsics(k):
    (fx, skew, cx), (_, fy, cy), _ = k
    return [[1 / fx, -skew / (fx * fy), (skew * cy - cx * fy) / (fx * fy)],
            [0, 1 / fy, -cy / fy],
            [0, 0, 1]]


def rows(numbers, width):
    return [numbers[i:i + width] for i in range(0, len(numbers), width)]


def fundamental(k0, k1, image1_from_0):
    rotation = [row[:3] for row in image1_from_0[:3]]
    x, y, z = (row[3] for row in image1_from_0[:3])
    essential = product([[0, -z, y], [z, 0, -x], [-y, x, 0]], rotation)
    return product(product(transposed(inverse_intrinsics(k1)), essential), inverse_intrinsics(k0))


def read_pairs(path):
    pairs = []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        fields = line.split()
        if len(fields) != 38 or fields[2:4] != ["0", "0"]:
            sys.exit(f"{path}:{number}: expected two names, 0 0 and 34 numbers")
        values = [float(field) for field in fields[4:]]
        k0, k1, transform = rows(values[:9], 3), rows(values[9:18], 3), rows(values[18:], 4)
        pairs.append((fields[0], fields[1], fundamental(k0, k1, transform)))
    return pairs


def distance(f, match):
    a, b, c = (row[0] * match["x0"] + row[1] * match["y0"] + row[2] for row in f)
    return abs(a * match["x1"] + b * match["y1"] + c) / math.hypot(a, b)


def steps_apart(pairs):
    names = sorted({name for pair in pairs for name in pair[:2]})
    return [abs(names.index(pair[0]) - names.index(pair[1])) for pair in pairs]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    program = pathlib.Path(__file__).parent / ".." / "build" / "release" / "apps" / "gluevo"
    parser.add_argument("--gluevo", type=pathlib.Path, default=program)
    parser.add_argument("--max-error", type=float, default=2.0, metavar="PX")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("options", nargs="*", default=[""])
    arguments = parser.parse_args()
    pairs = read_pairs(arguments.folder / "pairs_with_gt.txt")
    apart = steps_apart(pairs)
    kinds = sorted(set(apart))
    print("| `gluevo match` | " + " | ".join(f"{kind} apart" for kind in kinds)
          + " | median distance of those, px |")
    print("| --- " * (len(kinds) + 2) + "|")
    for options in arguments.options:
        right = {kind: [0, 0, 0] for kind in kinds}  # Matches within, all, pairs.
        near = []
        for (name0, name1, f), kind in zip(pairs, apart):
            images = [str(arguments.folder / name) for name in (name0, name1)]
            command = [str(arguments.gluevo), "match", *images, "--json", *options.split()]
            answer = subprocess.run(command, capture_output=True, text=True)
            if answer.returncode != 0:
                sys.exit(answer.stderr.strip())
            distances = [distance(f, match) for match in json.loads(answer.stdout)["matches"]]
            within = [d for d in distances if d <= arguments.max_error]
            near += within
            right[kind] = [a + b for a, b in zip(right[kind], (len(within), len(distances), 1))]
        cells = [f"{within / max(all_, 1):.3f} of {all_ / count:.0f}"
                 for within, all_, count in right.values()]
        median = f"{statistics.median(near):.2f}" if near else "-"
        print(f"| `{options or 'defaults'}` | " + " | ".join(cells) + f" | {median} |", flush=True)


if __name__ == "__main__":
    main()
