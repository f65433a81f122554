#!/usr/bin/env python3
"""Runs our detector and OpenCV's SIFT in turns on the same scene, and prints CPU times and their ratios.

OpenCV sees the middle frame alone; ours searches all ten frames. Both use one thread unless said otherwise, files are not counted.
On a scene each has the threshold at which it finds about 3000 features, which is looked for first. By day (a picture of ../shared, or of
BURSTSCOPE_SHARED, that moves, with noise) both have their defaults and keep the 3000 strongest. Needs the Python packages numpy and
opencv-python-headless.

    cargo bench --bench cpu_time --no-run
    python3 benches/versus_opencv.py [ROUNDS [PROGRAM]]
"""

import glob
import os
import statistics
import subprocess
import sys
import tempfile
import time

import cv2

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# What is asked of the program: name, threads, peak threshold.
RUNS = [("1d", 1), ("1d", 2), ("2d", 1), ("2d-field", 1), ("1d-doubled", 1), ("sift", 1)]
DAY = ["1d-day", "2d-day", "2d-day-field"]
FEATURES = 3000
# CPU time of one thread, of OpenCV's, that is aimed at.
AT_MOST = {"1d": 0.9, "2d": 3.8, "2d-field": 2.5, "1d-day": 1.0, "2d-day": 5.0, "2d-day-field": 3.3}


def program():
    """The program given, or the newest build of the benchmark."""
    if len(sys.argv) > 2:
        return sys.argv[2]
    found = [p for p in glob.glob(os.path.join(ROOT, "target/release/deps/cpu_time-*")) if not p.endswith(".d")]
    if not found:
        sys.exit("build it first: cargo bench --bench cpu_time --no-run")
    return max(found, key=os.path.getmtime)


class Ours:
    """The benchmark program, answering one line a request."""

    def __init__(self, folder):
        self.process = subprocess.Popen(
            [program(), folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        assert self.process.stdout.readline().strip() == "ready"

    def run(self, method, threads, threshold):
        self.process.stdin.write(f"{method} {threads} {threshold}\n")
        self.process.stdin.flush()
        _, features, cpu, wall, peak = self.process.stdout.readline().split()[:5]
        return int(features), float(cpu), float(wall), int(peak)


def threshold_for(count):
    """The threshold at which `count(threshold)`, which falls with the threshold, is within a hundredth of FEATURES."""
    low, high = 1e-5, 1.0
    for _ in range(20):
        middle = (low * high) ** 0.5
        found = count(middle)
        if abs(found - FEATURES) <= FEATURES / 100:
            return middle
        low, high = (middle, high) if found > FEATURES else (low, middle)
    sys.exit(f"no threshold gives {FEATURES} features; {middle:.2g} gives {found}")


def opencv(image, **options):
    """Features and CPU seconds of OpenCV's SIFT with descriptors."""
    start = time.process_time()
    keypoints, _ = cv2.SIFT_create(**options).detectAndCompute(image, None)
    return len(keypoints), time.process_time() - start


def table(title, theirs, results):
    """Prints the medians of runs in turns; ratios are those of each round's two times."""
    base = statistics.median(cpu for _, cpu in theirs)
    print(f"{title}: medians of {len(theirs)} rounds, 1600x1200; ours on 10 frames, 7 or 7x7 slopes, 3 levels")
    print(f"| {'what':<28} | features | CPU s | of OpenCV | at most | wall s | wall/CPU | peak MB |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    print(f"| {'OpenCV SIFT, one frame':<28} | {theirs[0][0]} | {base:.3f} | 1.00 | | | | |")
    for (method, threads), runs in results.items():
        cpu = statistics.median(r[1] for r in runs)
        wall = statistics.median(r[2] for r in runs)
        peak = max(r[3] for r in runs) / 1e6
        ratio = statistics.median(ours[1] / cpu for ours, (_, cpu) in zip(runs, theirs))
        name = f"{method}, {threads} thread" + ("s" if threads > 1 else "")
        bar = AT_MOST.get(method, "") if threads == 1 else ""
        print(
            f"| {name:<28} | {runs[0][0]} | {cpu:.3f} | {ratio:.2f} | {bar} | {wall:.3f} | {wall / cpu:.2f} | {peak:.0f} |"
        )


def main():
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        ours = Ours(folder)
        image = cv2.imread(os.path.join(folder, "scene.png"), cv2.IMREAD_GRAYSCALE)
        count = lambda threshold: opencv(image, contrastThreshold=threshold)[0]
        their_threshold = threshold_for(count)
        methods = sorted({method for method, _ in RUNS})
        thresholds = {m: threshold_for(lambda t, m=m: ours.run(m, 2, t)[0]) for m in methods}
        theirs, results = [], {run: [] for run in RUNS}
        for _ in range(rounds):
            theirs.append(opencv(image, contrastThreshold=their_threshold))
            for method, threads in RUNS:
                results[method, threads].append(ours.run(method, threads, thresholds[method]))
        table("equal thresholds", theirs, results)
        day = os.path.join(folder, "day.png")
        if not os.path.exists(day):
            sys.exit("no burst by day: its picture is not there")
        image = cv2.imread(day, cv2.IMREAD_GRAYSCALE)
        theirs, results = [], {(method, 1): [] for method in DAY}
        for _ in range(rounds):
            theirs.append(opencv(image, nfeatures=FEATURES))
            for method in DAY:
                results[method, 1].append(ours.run(method, 1, 0.0))
        print()
        table("defaults by day", theirs, results)


if __name__ == "__main__":
    main()
