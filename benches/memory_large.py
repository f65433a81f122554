"""The memory that a burst of ten frames of 20 megapixels takes: the peak that the operating system counts of a whole
`burstscope detect`, opening and decoding with it.

    cargo build --release && python3 benches/memory_large.py [BINARY]

Needs numpy and opencv-python-headless, 1 GB of room for temporary files, and a quarter of an hour on a busy machine.
"""

import os
import subprocess
import sys
import tempfile

import cv2
import numpy as np

WIDTH, HEIGHT, FRAMES = 5472, 3648, 10


def write_burst(folder, flicker):
    """Texture of all sizes that moves by 1.3 px per frame, with noise; 12 bit in 16-bit PNG."""
    os.makedirs(folder)
    rng = np.random.default_rng(3)
    scene = np.full((HEIGHT, WIDTH + 64), 0.3, np.float32)
    for step in (4, 8, 16, 32, 64):
        coarse = rng.standard_normal((HEIGHT // step + 2, (WIDTH + 64) // step + 2), dtype=np.float32)
        scene += 0.05 * cv2.resize(coarse, (WIDTH + 64, HEIGHT), interpolation=cv2.INTER_CUBIC)
    for t in range(FRAMES):
        shift = np.float32([[1, 0, 1.3 * (t - 4.5) - 32], [0, 1, 0]])
        frame = cv2.warpAffine(scene, shift, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR)
        frame += 0.03 * rng.standard_normal((HEIGHT, WIDTH), dtype=np.float32)
        frame *= 1 + flicker * np.sin(2.1 * t)
        pixels = (np.clip(frame, 0, 1) * 4095).astype(np.uint16) * 16
        cv2.imwrite(f"{folder}/frame_{t:03}.png", pixels, [cv2.IMWRITE_PNG_COMPRESSION, 1])


def peak_mb(command):
    """Peak resident memory of a command, MB (millions of bytes)."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{command} failed")
    return usage.ru_maxrss * 1024 / 1e6


def main():
    binary = sys.argv[1] if len(sys.argv) > 1 else "target/release/burstscope"
    seven = ["--slopes-u", "-3:3:7"]
    with tempfile.TemporaryDirectory() as home:
        plain, flickering = f"{home}/plain", f"{home}/flickering"
        write_burst(plain, 0.0)
        write_burst(flickering, 0.06)
        for name, arguments in [
            ("seven slopes", [plain, *seven]),
            ("seven slopes in groups, --memory 2G", [plain, *seven, "--memory", "2G"]),
            ("slopes auto", [plain]),
            ("seven slopes, flicker taken off", [flickering, *seven]),
        ]:
            command = [binary, "detect", *arguments, "--quiet", "--out", f"{home}/found"]
            print(f"{name}: {peak_mb(command):.0f} MB", flush=True)


if __name__ == "__main__":
    main()
