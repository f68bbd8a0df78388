"""The command bench/compare_engines."""

import argparse
import json
import os
import pathlib
import subprocess
import sys

import numpy as np

from . import agreement, cases, networks, report, rounds
from .cases import GLUEVO, Case, Key, Outputs
from .contestants import Contestant, Engine, Gluevo, reference
from .engine import ENGINES, runs

FOLDER = networks.ROOT / "build" / "compare_engines"
DEFAULT_ENGINES = ["onnxruntime", "openvino", "ncnn"]
# Others run in fp32 only.
BF16_WORKS = (cases.SUPERPOINT, cases.SUPERGLUE)


def parse_size(text: str) -> tuple[int, int]:
    width, height = map(int, text.split("x"))
    return width, height


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="bench/compare_engines",
        description="How much faster gluevo runs its networks than inference engines, on this "
        "machine and in one run: prints Markdown. gluevo's SuperPoint goes from the image to "
        "keypoints and descriptors, the engines' is the dense network alone, and so with ALIKED; "
        "SuperGlue includes 100 Sinkhorn iterations; LightGlue runs all layers. Without weights files, random weights of the published shapes.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--work", nargs="+", choices=cases.ALL, default=list(cases.ALL))
    add("--engines", nargs="+", choices=list(ENGINES), default=DEFAULT_ENGINES)
    add("--precision", nargs="+", choices=["fp32", "bf16"], default=["fp32", "bf16"])
    add("--threads", nargs="+", type=int, default=[len(os.sched_getaffinity(0))])
    add("--keypoints", nargs="+", type=int, default=[200, 500, 1024], help="for SuperGlue and LightGlue")
    add("--size", type=parse_size, default="752x480", help="of the image, pixels")
    add("--image", type=pathlib.Path, help="for SuperPoint and ALIKED, in place of a synthetic one")
    add("--superpoint", type=pathlib.Path, help="weights, .safetensors or .npz")
    for name in (cases.SUPERGLUE, cases.ALIKED, cases.LIGHTGLUE):
        add(f"--{name}", type=pathlib.Path, help="weights, .safetensors or .npz")
    add("--rounds", type=int, default=15, help="that count")
    add(
        "--max-foreign",
        type=float,
        default=0.1,
        metavar="PROCESSORS",
        help="a round in which others used more is discarded",
    )
    add(
        "--patience",
        type=float,
        default=5.0,
        metavar="MINUTES",
        help="for each work, spent on waiting for a quiet machine and on discarded rounds",
    )
    add("--pause-ms", type=float, default=50.0, help="between engines")
    default = networks.ROOT / "build" / "release" / "apps" / "gluevo"
    add("--gluevo", type=pathlib.Path, default=default, help="the program")
    arguments = parser.parse_args()
    if not arguments.gluevo.is_file():
        parser.error(f"{arguments.gluevo}: no such program; build it, or name another by --gluevo")
    return arguments


def gluevo_precisions(program: pathlib.Path) -> list[str]:
    usage = subprocess.run([program, "bench", "--help"], check=True, capture_output=True, text=True)
    return ["fp32", "bf16"] if "--precision" in usage.stdout else ["fp32"]


def machine(program: pathlib.Path) -> str:
    command = [str(program), "bench", "--json", "--rounds", "1", "--size", "64x64"]
    answer = subprocess.run(command, check=True, capture_output=True, text=True)
    isa = json.loads(answer.stdout)["isa"]
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    model = names[0] if names else "unknown processor"
    return f"{model}, {os.cpu_count()} processors, gluevo's instruction set {isa}"


def make_cases(arguments: argparse.Namespace) -> list[Case]:
    made: list[Case] = []
    if cases.SUPERPOINT in arguments.work:
        made.append(cases.superpoint(FOLDER, arguments.superpoint, arguments.image, arguments.size))
    if cases.SUPERGLUE in arguments.work:
        for count in arguments.keypoints:
            made.append(cases.superglue(FOLDER, arguments.superglue, count, arguments.size))
    if cases.ALIKED in arguments.work:
        made.append(cases.aliked(FOLDER, arguments.aliked, arguments.image, arguments.size))
    if cases.LIGHTGLUE in arguments.work:
        for count in arguments.keypoints:
            made.append(cases.lightglue(FOLDER, arguments.lightglue, count, arguments.size))
    return made


def make_contestants(
    case: Case, image: np.ndarray | None, arguments: argparse.Namespace, precisions: list[str]
) -> tuple[list[Contestant], list[str]]:
    """And notes on them. gluevo always runs with one thread too."""
    pause_s = arguments.pause_ms / 1e3
    contestants: list[Contestant] = []
    notes = []
    for threads in dict.fromkeys([*arguments.threads, 1]):
        for precision in precisions:
            process = Gluevo(arguments.gluevo, case, Key(GLUEVO, precision, threads), FOLDER)
            process.measure()
            contestants.append(process)
    for threads in arguments.threads:
        for engine in arguments.engines:
            for precision in precisions:
                if precision not in ENGINES[engine].PRECISIONS or not runs(engine, case):
                    continue
                made = Engine(case, image, Key(engine, precision, threads), pause_s)
                contestants.append(made)
                if made.sinkhorn not in ("", ENGINES[engine].NAME):
                    notes.append(
                        f"{case.name}, {precision}, {threads} threads: {ENGINES[engine].NAME} has "
                        f"no Sinkhorn and takes the fastest of the others, {made.sinkhorn}'s."
                    )
    return contestants, notes


def check(contestants: list[Contestant], expected: Outputs, case: Case) -> list[str]:
    """Lines on how much they differ; ends the program where one computes something else."""
    agreements = {}
    for contestant in contestants:
        key = contestant.key
        agreements[key] = agreement.compare(contestant.outputs(), expected, case.kind)
        if not agreements[key].within(key.precision):
            raise SystemExit(
                f"{case.name}: {report.NAMES[key.engine]} {key.precision} differs from gluevo in "
                f"fp32 by more than {agreement.TOLERANCE[key.precision]:.1e}: {agreements[key]}"
            )
    most = max(key.threads for key in agreements)
    itself = Key(GLUEVO, "fp32", most)
    shown = {k: value for k, value in agreements.items() if k.threads == most and k != itself}
    return [f"{case.name}, {line}" for line in agreement.describe(shown, report.NAMES)]


def main() -> int:
    arguments = parse_arguments()
    FOLDER.mkdir(parents=True, exist_ok=True)
    available = gluevo_precisions(arguments.gluevo)
    precisions = [p for p in available if p in arguments.precision]
    if not precisions:
        raise SystemExit(f"{arguments.gluevo} knows no --precision {arguments.precision[0]}")
    limits = rounds.Limits(
        arguments.rounds,
        arguments.max_foreign,
        arguments.patience * 60,
        arguments.pause_ms / 1e3,
    )

    print(machine(arguments.gluevo) + ".\n")
    print("\n".join(report.header(arguments.engines)), flush=True)
    lines, notes = [], []
    complete = True
    for case in make_cases(arguments):
        print(case.name, file=sys.stderr)
        expected = reference(arguments.gluevo, case, FOLDER)
        image = expected.pop("image", None)
        shared = [p for p in precisions if p == "fp32" or case.kind in BF16_WORKS]
        contestants, more_notes = make_contestants(case, image, arguments, shared)
        lines += check(contestants, expected, case)
        record = rounds.run(contestants, limits)
        for contestant in contestants:
            contestant.close()
        for row in report.rows(case.name, record, arguments.engines, shared, arguments.threads):
            print(row, flush=True)
        notes += more_notes
        notes.append(
            f"{case.name}: {len(record.times_ms)} rounds, others used at most "
            f"{record.foreign:.2f} processors in them; {record.discarded} more discarded. Least "
            f"times: {report.least(record)}."
        )
        complete &= len(record.times_ms) == arguments.rounds
    print(report.EXPLANATION)
    print("\n".join(f"- {note}" for note in notes))
    print(report.AGREEMENT_EXPLANATION)
    print("\n".join(f"- {line}" for line in lines))
    if not complete:
        print(f"fewer than {arguments.rounds} quiet rounds: the machine is busy", file=sys.stderr)
    return 0 if complete else 1


if __name__ == "__main__":
    sys.exit(main())
