#!/usr/bin/env python3
"""What an inertial unit is worth: runs of flights with and without it.

    bench/inertial.py [--gluevo PROGRAM] [--work DIR] [--methods klt,...] FLIGHT...

FLIGHTs are data sets of `gluevo simulate`, or recorded ones in EuRoC's layout with the ground
truth's biases. Prints Markdown: errors without and with the unit; how far the body's tilt is off
from the first inertial pose on; how far gravity is off after 5 s of flight, and the biases after 20;
with --blackouts S,... how far off the path is where images are black for so many seconds in the
middle. Runs that --work has are not made again. Needs Python alone.
"""
import argparse
import bisect
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib


# Quaternions are (w, x, y, z).
def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def rotate(q, v):
    w, x, y, z = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz,
            v[2] + w * tz + x * ty - y * tx)


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def norm(v):
    return math.sqrt(sum(x * x for x in v))


def angle_deg(a, b):
    cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    return math.degrees(math.atan2(norm(cross), sum(x * y for x, y in zip(a, b))))


class Truth:
    """A flight's ground truth: position, rotation and biases by time in nanoseconds."""

    def __init__(self, flight):
        path = flight / "mav0/state_groundtruth_estimate0/data.csv"
        rows = [line.split(",") for line in path.read_text().splitlines() if line[:1].isdigit()]
        self.times = [int(row[0]) for row in rows]
        self.rows = [tuple(float(value) for value in row[1:]) for row in rows]

    def at(self, time_ns):
        """The row nearest in time; nothing more than 5 ms away."""
        i = bisect.bisect_left(self.times, time_ns)
        nearest = min((j for j in (i - 1, i) if 0 <= j < len(self.times)),
                      key=lambda j: abs(self.times[j] - time_ns))
        return self.rows[nearest] if abs(self.times[nearest] - time_ns) <= 5_000_000 else None


def read_trajectory(path):
    """(time in nanoseconds, position, rotation) a pose."""
    poses = []
    for line in path.read_text().splitlines():
        if line and not line.startswith("#"):
            seconds, *values = line.split()
            whole, _, part = seconds.partition(".")
            time_ns = int(whole) * 10**9 + int(part.ljust(9, "0")[:9])
            x, y, z, qx, qy, qz, qw = map(float, values)
            poses.append((time_ns, (x, y, z), (qw, qx, qy, qz)))
    return poses


class Runner:
    def __init__(self, gluevo, work):
        self.gluevo, self.work = gluevo, work

    def run(self, flight, name, *options):
        folder = self.work / name
        if not (folder / "metrics.json").exists():
            folder.mkdir(parents=True, exist_ok=True)
            with open(folder / "run.log", "w") as log:
                code = subprocess.call([self.gluevo, "run", str(flight), "-o", str(folder), *options],
                                       stdout=log, stderr=log)
            if code != 0:
                sys.exit(f"gluevo run failed, see {folder / 'run.log'}")
        return folder, json.loads((folder / "metrics.json").read_text())


def frame_times(flight):
    lines = (flight / "mav0/cam0/data.csv").read_text().splitlines()
    return [int(line.split(",")[0]) for line in lines if line[:1].isdigit()]


def tilt(poses, truth, first_ns):
    """Largest angle between where the body has 'up' and where it is, degrees."""
    worst = None
    for time_ns, _, rotation in poses:
        row = truth.at(time_ns)
        if time_ns >= first_ns and row:
            off = angle_deg(rotate(conjugate(rotation), (0, 0, 1)),
                            rotate(conjugate(row[3:7]), (0, 0, 1)))
            worst = max(off, worst or 0.0)
    return worst


def after(runner, flight, name, matches, method, seconds):
    """The unit's estimates by the frame that comes so many seconds after the first one."""
    times = frame_times(flight)
    count = bisect.bisect_right(times, times[0] + round(seconds * 1e9))
    _, metrics = runner.run(flight, f"{name}_{seconds}s", "--method", method, "--imu", "on",
                            "--replay", str(matches), "--count", str(count))
    return metrics["imu"], times[0], times[count - 1]


def gravity_error(imu, truth, first_ns):
    row = truth.at(first_ns)
    if "gravity" not in imu or row is None:
        return None
    return angle_deg(imu["gravity"], rotate(conjugate(row[3:7]), (0, 0, -1)))


def bias_errors(imu, truth, now_ns):
    row = truth.at(now_ns)
    if "gyroscope_bias" not in imu or row is None:
        return None, None
    return (norm(minus(imu["gyroscope_bias"], row[10:13])),
            norm(minus(imu["accelerometer_bias"], row[13:16])))


def black_png(like):
    """A black image of the size of that one, which is a PNG."""
    width, height = struct.unpack(">II", like.read_bytes()[16:24])

    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data +
                struct.pack(">I", zlib.crc32(kind + data)))

    rows = zlib.compress(bytes((width + 1) * height))
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) +
            chunk(b"IEND", b""))


def black_out(flight, seconds, target):
    """A copy by links whose images are black from the middle on; the numbers of these frames."""
    times = frame_times(flight)
    begin = times[len(times) // 2]
    dark = {t for t in times if begin <= t < begin + round(seconds * 1e9)}
    for part in ("imu0", "state_groundtruth_estimate0"):
        (target / "mav0").mkdir(parents=True, exist_ok=True)
        if not (target / "mav0" / part).exists():
            (target / "mav0" / part).symlink_to((flight / "mav0" / part).resolve())
    for camera in ("cam0", "cam1"):
        source, copy = flight / "mav0" / camera, target / "mav0" / camera
        (copy / "data").mkdir(parents=True, exist_ok=True)
        for name in ("data.csv", "sensor.yaml"):
            (copy / name).write_bytes((source / name).read_bytes())
        for image in (source / "data").iterdir():
            link = copy / "data" / image.name
            if link.exists():
                continue
            if int(image.stem) in dark:
                link.write_bytes(black_png(image))
            else:
                link.symlink_to(image.resolve())
    return sorted(dark)


def bridge_error(poses, truth, dark):
    """Of the motion since the last frame before the dark, the largest up to the first one after."""
    of = {time_ns: (position, rotation) for time_ns, position, rotation in poses}
    times = [pose[0] for pose in poses]
    before = times[times.index(dark[0]) - 1]
    end = times[times.index(dark[-1]) + 1]

    def motion(start, start_rotation, now):
        return rotate(conjugate(start_rotation), minus(now, start))

    worst = 0.0
    for time_ns in (*dark, end):
        row0, row1 = truth.at(before), truth.at(time_ns)
        there = motion(row0[0:3], row0[3:7], row1[0:3])
        worst = max(worst, norm(minus(motion(*of[before], of[time_ns][0]), there)))
    return worst


def text(value, decimals):
    return "-" if value is None else f"{value:.{decimals}f}"


def with_and_without(runner, flights, methods):
    print("| flight | method | ATE SE(3), mm, without / with (ratio) | RPE, % (ratio) | starts, s | "
          "tilt, deg | gravity after 5 s, deg | biases after 20 s, rad/s, m/s^2 |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for flight in flights:
        truth = Truth(flight)
        for method in methods:
            name = f"{flight.name}_{method}"
            _, off = runner.run(flight, name + "_off", "--method", method, "--imu", "off")
            matches = runner.work / f"{name}.h5"
            folder, on = runner.run(flight, name + "_on", "--method", method, "--imu", "on",
                                    "--save-matches", str(matches))
            poses = read_trajectory(folder / "trajectory.tum")
            start = on["imu"]["initialised_at_s"]
            first = None if start is None else poses[0][0] + round(start * 1e9)
            early, first_ns, _ = after(runner, flight, name, matches, method, 5)
            late, _, now_ns = after(runner, flight, name, matches, method, 20)

            def both(key, factor, decimals):
                a, b = off.get(key), on.get(key)
                if a is None or b is None:
                    return "-"
                return f"{factor * a:.{decimals}f} / {factor * b:.{decimals}f} ({b / a:.2f})"

            biases = bias_errors(late, truth, now_ns)
            print(f"| {flight.name} | {method} | {both('ate_se3_m', 1e3, 2)} | "
                  f"{both('rpe_translation_percent', 1, 3)} | {text(start, 1)} | "
                  f"{text(None if first is None else tilt(poses, truth, first), 2)} | "
                  f"{text(gravity_error(early, truth, first_ns), 3)} | "
                  f"{text(biases[0], 5)}, {text(biases[1], 3)} |", flush=True)


def blackouts(runner, flights, methods, durations):
    print("\n| flight | method | " + " | ".join(f"{s:g} s dark, m" for s in durations) + " |")
    print("| --- | --- |" + " --- |" * len(durations))
    for flight in flights:
        truth = Truth(flight)
        for method in methods:
            cells = []
            for seconds in durations:
                copy = runner.work / f"{flight.name}_dark{seconds:g}"
                dark = black_out(flight, seconds, copy)
                folder, metrics = runner.run(copy, f"{copy.name}_{method}", "--method", method,
                                             "--imu", "on")
                error = bridge_error(read_trajectory(folder / "trajectory.tum"), truth, dark)
                resets = metrics["resets"]
                cells.append(text(error, 3) + (f", {resets + 1} segments" if resets else ""))
            print(f"| {flight.name} | {method} | " + " | ".join(cells) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    root = pathlib.Path(__file__).resolve().parent.parent
    parser.add_argument("--gluevo", default=str(root / "build/release/apps/gluevo"))
    parser.add_argument("--work", type=pathlib.Path, help="folder of the runs; default: a new one")
    parser.add_argument("--methods", default="klt,superpoint,superglue")
    parser.add_argument("--blackouts", default="", metavar="S,S...", help="seconds, such as 0.5,2")
    parser.add_argument("--only-blackouts", action="store_true")
    parser.add_argument("flights", nargs="+", type=pathlib.Path)
    arguments = parser.parse_args()
    methods = arguments.methods.split(",")
    durations = [float(part) for part in arguments.blackouts.split(",") if part]
    with tempfile.TemporaryDirectory() as temporary:
        runner = Runner(arguments.gluevo, arguments.work or pathlib.Path(temporary))
        if not arguments.only_blackouts:
            with_and_without(runner, arguments.flights, methods)
        if durations:
            blackouts(runner, arguments.flights, methods, durations)


main()
