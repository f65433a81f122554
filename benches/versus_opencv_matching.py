#!/usr/bin/env python3
"""Runs our exact descriptor search and OpenCV's brute-force L2 matcher in turns on the same descriptors; prints times and their ratio.

Both find the two nearest of N descriptors for each of N others, on the same number of threads. That the answers agree is checked too. Needs the Python packages
numpy and opencv-python-headless.

    cargo bench --bench matching --no-run
    python3 benches/versus_opencv_matching.py [N [ROUNDS [PROGRAM]]]
"""

import glob
import os
import statistics
import subprocess
import sys
import tempfile
import time

import cv2
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def program():
    """The newest build of the benchmark."""
    found = [p for p in glob.glob(os.path.join(ROOT, "target/release/deps/matching-*")) if not p.endswith(".d")]
    if not found:
        sys.exit("build it first: cargo bench --bench matching --no-run")
    return max(found, key=os.path.getmtime)


def opencv(a, b):
    """Matches, wall and CPU seconds of knnMatch."""
    matcher = cv2.BFMatcher(cv2.NORM_L2)
    wall, cpu = time.perf_counter(), time.process_time()
    matches = matcher.knnMatch(a, b, k=2)
    return matches, time.perf_counter() - wall, time.process_time() - cpu


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 3000
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 15
    with tempfile.TemporaryDirectory() as folder:
        binary = sys.argv[3] if len(sys.argv) > 3 else program()
        ours = subprocess.Popen([binary, str(count), folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

        def ask(line):
            ours.stdin.write(f"{line}\n")
            ours.stdin.flush()
            return ours.stdout.readline().split()

        assert ours.stdout.readline().strip() == "ready"
        # OpenCV's L2 norm wants floats.
        a, b = (np.load(os.path.join(folder, f"{side}.npy")).astype(np.float32) for side in "ab")
        assert ask("nearest") == ["written"]
        nearest = np.load(os.path.join(folder, "nearest.npy"))
        theirs, _, _ = opencv(a, b)
        distances = np.array([[first.distance, second.distance] for first, second in theirs])
        assert np.allclose(distances**2, nearest[:, 1:], rtol=1e-4, atol=0.5), "the distances differ"
        same = np.mean([first.trainIdx == index for (first, _), index in zip(theirs, nearest[:, 0])])
        print(f"{count}×{count} descriptors; the same nearest neighbour for {100 * same:.2f} %")
        print(f"{'threads':>8}{'OpenCV ms':>12}{'ours ms':>12}{'ratio':>8}{'OpenCV CPU':>12}{'our CPU ms':>12}")
        for threads in (1, 2):
            cv2.setNumThreads(threads)
            times = []
            for _ in range(rounds):
                _, wall, cpu = opencv(a, b)
                our_wall, our_cpu = map(float, ask(threads))
                times.append((wall, our_wall, cpu, our_cpu))
            wall, our_wall, cpu, our_cpu = (1000 * statistics.median(column) for column in zip(*times))
            print(f"{threads:>8}{wall:>12.1f}{our_wall:>12.1f}{our_wall / wall:>8.2f}{cpu:>12.1f}{our_cpu:>12.1f}")
        ours.stdin.close()
        ours.wait()


if __name__ == "__main__":
    main()
