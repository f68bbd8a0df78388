"""The command bench/compare_engines."""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import time
from typing import Sequence

from . import agreement, cases, networks, report, rounds
from .cases import Case, SuperGlueCase, SuperPointCase
from .contestants import (
    ENGINES,
    GLUEVO,
    Contestant,
    Gluevo,
    Key,
    superglue_engine,
    superpoint_engine,
)

FOLDER = networks.ROOT / "build" / "compare_engines"
# Until gluevo has loaded a network and run it once.
SETTLE_S = 0.5


def parse_size(text: str) -> tuple[int, int]:
    width, height = map(int, text.split("x"))
    return width, height


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="bench/compare_engines",
        description="How much faster gluevo runs its networks than inference engines, on this "
        "machine and in one run: prints Markdown. gluevo's SuperPoint goes from the image to "
        "keypoints and descriptors, the engines' is the dense network alone; SuperGlue includes "
        "100 Sinkhorn iterations. Without weights files, random weights of the published shapes.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    works = [cases.SUPERPOINT, cases.SUPERGLUE]
    add("--work", nargs="+", choices=works, default=works)
    add("--engines", nargs="+", choices=list(ENGINES), default=list(ENGINES))
    add("--precision", nargs="+", choices=["fp32", "bf16"], default=["fp32", "bf16"])
    add("--threads", nargs="+", type=int, default=[os.cpu_count()])
    add("--keypoints", nargs="+", type=int, default=[200, 500, 1024], help="for SuperGlue")
    add("--size", type=parse_size, default="752x480", help="of the image, pixels")
    add("--image", type=pathlib.Path, help="for SuperPoint, in place of a synthetic one")
    add("--superpoint", type=pathlib.Path, help="weights, .safetensors or .npz")
    add("--superglue", type=pathlib.Path, help="weights, .safetensors or .npz")
    add("--rounds", type=int, default=15, help="that count")
    add("--most-rounds", type=int, help="that are tried; default: four times --rounds")
    add("--max-foreign", type=float, default=0.1, metavar="PROCESSORS",
        help="a round in which others used more is discarded")  # fmt: skip
    add("--pause-ms", type=float, default=50.0, help="between engines")
    default = networks.ROOT / "build" / "release" / "apps" / "gluevo"
    add("--gluevo", type=pathlib.Path, default=default, help="the program")
    arguments = parser.parse_args()
    if not arguments.gluevo.is_file():
        parser.error(f"{arguments.gluevo}: no such program; build it, or name another by --gluevo")
    if arguments.most_rounds is None:
        arguments.most_rounds = 4 * arguments.rounds
    return arguments


def gluevo_precisions(program: pathlib.Path) -> list[str]:
    usage = subprocess.run([program, "bench", "--help"], check=True, capture_output=True, text=True)
    return ["fp32", "bf16"] if "--precision" in usage.stdout else ["fp32"]


def machine(program: pathlib.Path) -> str:
    command = [program, "bench", "--json", "--rounds", "1", "--size", "64x64"]
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
    return made


def check(contestants: Sequence[Contestant], case: Case) -> list[str]:
    """Compares all with the first; ends the program where one computes something else."""
    expected = contestants[0].outputs()
    agreements = {}
    for contestant in contestants[1:]:
        key = contestant.key
        if key.threads == contestants[0].key.threads:
            time.sleep(SETTLE_S)
            agreements[key] = agreement.compare(contestant.outputs(), expected)
            if not agreements[key].within(key.precision):
                raise SystemExit(
                    f"{case.name}: {report.NAMES[key.engine]} {key.precision} differs from gluevo "
                    f"by {agreements[key]}, tolerance {agreement.TOLERANCE[key.precision]}"
                )
    return [f"{case.name}, {line}" for line in agreement.describe(agreements, report.NAMES)]


def compare(
    case: Case, arguments: argparse.Namespace, precisions: list[str]
) -> tuple[rounds.Record, list[str], list[str]]:
    """The times, lines on agreement, and notes."""
    pause_s = arguments.pause_ms / 1e3
    notes = []
    processes: list[Gluevo] = []
    # gluevo in fp32 with the first number of threads is what the others are compared with.
    for threads in dict.fromkeys([*arguments.threads, 1]):
        for precision in precisions:
            key = Key(GLUEVO, precision, threads)
            processes.append(Gluevo(arguments.gluevo, case, key, FOLDER))
            processes[-1].measure()
    contestants: list[Contestant] = list(processes)
    for threads in arguments.threads:
        for engine in arguments.engines:
            for precision in set(precisions) & set(ENGINES[engine].PRECISIONS):
                key = Key(engine, precision, threads)
                if isinstance(case, SuperPointCase):
                    image = processes[0].outputs()["image"]
                    contestants.append(superpoint_engine(case, image, key, pause_s))
                else:
                    made, sinkhorn = superglue_engine(case, key, pause_s)
                    contestants.append(made)
                    if sinkhorn != ENGINES[engine].NAME:
                        notes.append(
                            f"{case.name}, {precision}, {threads} threads: {ENGINES[engine].NAME} "
                            f"has no Sinkhorn and takes the fastest of the others, {sinkhorn}'s."
                        )
    lines = check(contestants, case)
    limits = rounds.Limits(arguments.rounds, arguments.most_rounds, arguments.max_foreign, pause_s)
    record = rounds.run(contestants, limits)
    for process in processes:
        process.close()
    notes.append(
        f"{case.name}: {len(record.times_ms)} rounds, others used at most {record.foreign:.2f} "
        f"processors in them; {record.discarded} more discarded."
    )
    return record, lines, notes


def main() -> int:
    arguments = parse_arguments()
    FOLDER.mkdir(parents=True, exist_ok=True)
    available = gluevo_precisions(arguments.gluevo)
    precisions = [p for p in available if p in arguments.precision]
    if not precisions:
        raise SystemExit(f"{arguments.gluevo} knows no --precision {arguments.precision[0]}")
    table, agreements, notes = report.header(arguments.engines), [], []
    complete = True
    for case in make_cases(arguments):
        print(case.name, file=sys.stderr)
        record, lines, more_notes = compare(case, arguments, precisions)
        table += report.rows(case.name, record, arguments.engines, precisions, arguments.threads)
        agreements += lines
        notes += more_notes
        complete &= len(record.times_ms) == arguments.rounds
    print(machine(arguments.gluevo) + ".\n")
    print("\n".join(table))
    print(report.EXPLANATION)
    print("\n".join(f"- {note}" for note in notes))
    print(report.AGREEMENT_EXPLANATION)
    print("\n".join(f"- {line}" for line in agreements))
    if not complete:
        print(f"fewer than {arguments.rounds} quiet rounds: the machine is busy", file=sys.stderr)
    return 0 if complete else 1


if __name__ == "__main__":
    sys.exit(main())
