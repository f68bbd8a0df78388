#!/usr/bin/env python3
"""How many motions between stereo frames that lie far apart are right, one by one, without odometry.

    bench/key_frame_motions.py [--gluevo PROGRAM] [--apart 1,2,5] MAV0 [OPTIONS...]

MAV0 is the folder mav0 of an EuRoC data set. Each of OPTIONS, in quotes, is what `gluevo extract` and
`gluevo match` get besides their files (500 keypoints): a row of the table. Frame i's stereo matches
within 2 px of their epipolar lines become points, those that match frame i + k's left image give its
pose (AP3P in RANSAC at 2 px); right is what is within 0.1 m and 2 degrees of the ground truth's
motion. Prints Markdown. Needs python3-opencv, python3-h5py and python3-yaml.
"""
import argparse
import csv
import pathlib
import statistics
import subprocess
import sys
import tempfile

import cv2
import h5py
import numpy as np
import yaml

FOCAL = 460.0  # Of the image in which errors are measured.
MAX_PIXELS = 2.0


def read_camera(folder):
    text = (folder / "sensor.yaml").read_text().replace("%YAML:1.0", "")
    values = yaml.safe_load(text)
    fx, fy, cx, cy = values["intrinsics"]
    k = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    return k, np.array(values["distortion_coefficients"]), np.array(values["T_BS"]["data"]).reshape(4, 4)


def pose_of(row):
    x, y, z, qw, qx, qy, qz = (float(value) for value in row[1:8])
    rotation = np.array([
        [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw)],
        [2 * (qx * qy + qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qx * qw)],
        [2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx * qx + qy * qy)]])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, (x, y, z)
    return pose


def read_rows(path):
    return [row for row in csv.reader(path.open()) if row and not row[0].startswith("#")]


def run(program, *arguments):
    answer = subprocess.run([str(program), *arguments], capture_output=True, text=True)
    if answer.returncode != 0:
        sys.exit(answer.stderr.strip())


class Frames:
    def __init__(self, mav0):
        self.mav0 = mav0
        rows = read_rows(mav0 / "cam0" / "data.csv")
        right = {row[0]: row[1] for row in read_rows(mav0 / "cam1" / "data.csv")}
        self.left = [f"cam0/data/{row[1]}" for row in rows]
        self.right = [f"cam1/data/{right[row[0]]}" for row in rows]
        self.k, self.distortion, self.body_from_left = read_camera(mav0 / "cam0")
        self.k1, self.distortion1, body_from_right = read_camera(mav0 / "cam1")
        self.right_from_left = np.linalg.inv(body_from_right) @ self.body_from_left
        truth = read_rows(mav0 / "state_groundtruth_estimate0" / "data.csv")
        stamps = np.array([int(row[0]) for row in truth])
        nearest = [int(np.argmin(np.abs(stamps - int(row[0])))) for row in rows]
        self.known = [abs(int(stamps[n]) - int(row[0])) < 3e6 for n, row in zip(nearest, rows)]
        self.poses = [pose_of(truth[n]) @ self.body_from_left for n in nearest]


def rays(keypoints, k, distortion):
    return cv2.undistortPoints(keypoints.reshape(-1, 1, 2).astype(np.float64), k,
                               distortion).reshape(-1, 2)


def triangulated(frames, left, right):
    """Points of the matches that fit the epipolar geometry, in the left camera; which; distances."""
    rotation, translation = frames.right_from_left[:3, :3], frames.right_from_left[:3, 3]
    x, y, z = translation
    essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ rotation
    homogeneous = np.column_stack([left, np.ones(len(left))])
    lines = homogeneous @ essential.T
    distances = FOCAL * np.abs(np.sum(lines * np.column_stack([right, np.ones(len(right))]), 1)
                               ) / np.hypot(lines[:, 0], lines[:, 1])
    points = cv2.triangulatePoints(np.eye(3, 4), frames.right_from_left[:3], left.T, right.T)
    points = (points[:3] / points[3]).T
    return points, (distances < MAX_PIXELS) & (points[:, 2] > 0.1) & (points[:, 2] < 100), distances


def motion_error(frames, i, j, points, observed):
    """Metres and degrees of the motion from frame i to j; None where there are too few points."""
    if len(points) < 4:
        return None
    camera = np.diag([FOCAL, FOCAL, 1.0])
    cv2.setRNGSeed(0)
    found, turn, translation, _ = cv2.solvePnPRansac(
        points, observed * FOCAL, camera, None, flags=cv2.SOLVEPNP_AP3P, iterationsCount=2000,
        reprojectionError=MAX_PIXELS, confidence=0.9999)
    if not found:
        return None
    estimate = np.eye(4)
    estimate[:3, :3], estimate[:3, 3] = cv2.Rodrigues(turn)[0], translation.ravel()
    truth = np.linalg.inv(frames.poses[j]) @ frames.poses[i]
    error = np.linalg.inv(estimate) @ truth
    angle = np.degrees(np.linalg.norm(cv2.Rodrigues(error[:3, :3])[0]))
    return np.linalg.norm(error[:3, 3]), angle


def evaluate(frames, program, options, apart):
    count = len(frames.left)
    with tempfile.TemporaryDirectory() as folder:
        features, matches = f"{folder}/features.h5", f"{folder}/matches.h5"
        pairs = pathlib.Path(folder) / "pairs.txt"
        names = list(zip(frames.left, frames.right))
        for k in apart:
            names += zip(frames.left, frames.left[k:])
        pairs.write_text("".join(f"{a} {b}\n" for a, b in names))
        of_networks = [o for o in options.split() if o]
        extraction, matching = list(of_networks), list(of_networks)
        if "--matcher" in extraction:
            at = extraction.index("--matcher")
            del extraction[at:at + 2]
        run(program, "extract", str(frames.mav0), "-o", features, "--max-keypoints", "500", *extraction)
        run(program, "match", features, "--pairs", str(pairs), "-o", matches, *matching)
        with h5py.File(features) as file:
            keypoints = {name: file[name]["keypoints"][:] for name in frames.left + frames.right}
        with h5py.File(matches) as file:
            found = {pair: file[pair[0].replace("/", "-")][pair[1].replace("/", "-")]["matches0"][:]
                     for pair in names}
    left = [rays(keypoints[name], frames.k, frames.distortion) for name in frames.left]
    right = [rays(keypoints[name], frames.k1, frames.distortion1) for name in frames.right]
    points, of_keypoint, distances, counts = [], [], [], []
    for i in range(count):
        match = found[(frames.left[i], frames.right[i])]
        used = np.flatnonzero(match >= 0)
        in_space, good, off = triangulated(frames, left[i][used], right[i][match[used]])
        points.append(in_space[good])
        index = np.full(len(match), -1)
        index[used[good]] = np.arange(good.sum())
        of_keypoint.append(index)
        distances += list(off[good])
        counts.append(int(good.sum()))
    cells, first = [], []
    for k in apart:
        right_ones = total = 0
        for i in range(count - k):
            if not (frames.known[i] and frames.known[i + k]):
                continue
            match = found[(frames.left[i], frames.left[i + k])]
            used = np.flatnonzero((match >= 0) & (of_keypoint[i] >= 0))
            error = motion_error(frames, i, i + k, points[i][of_keypoint[i][used]],
                                 left[i + k][match[used]])
            total += 1
            right_ones += error is not None and error[0] < 0.1 and error[1] < 2.0
            if k == apart[0] and error is not None:
                first.append(error[0])
        cells.append(f"{right_ones} of {total}")
    rms = float(np.sqrt(np.mean(np.square(distances))))
    print(f"| `{options or 'defaults'}` | {rms:.2f} | {statistics.median(counts):.0f} | "
          + " | ".join(cells) + f" | {statistics.median(first):.4f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    program = pathlib.Path(__file__).parent / ".." / "build" / "release" / "apps" / "gluevo"
    parser.add_argument("--gluevo", type=pathlib.Path, default=program)
    parser.add_argument("--apart", default="1,2,5")
    parser.add_argument("mav0", type=pathlib.Path)
    parser.add_argument("options", nargs="*", default=[""])
    arguments = parser.parse_args()
    apart = [int(k) for k in arguments.apart.split(",")]
    frames = Frames(arguments.mav0)
    print("| options | epipolar RMS, px | stereo matches | "
          + " | ".join(f"right, {k} apart" for k in apart) + f" | median error at {apart[0]}, m |")
    print("| --- " * (len(apart) + 4) + "|")
    for options in arguments.options:
        evaluate(frames, arguments.gluevo.resolve(), options, apart)


if __name__ == "__main__":
    main()
