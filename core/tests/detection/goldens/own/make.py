#!/usr/bin/env python3
"""Makes the answers beside this file: VLFeat's SIFT, by pycolmap, on pictures of our own making.

    pip install pycolmap==4.2.1 numpy pillow
    python3 tests/goldens/own/make.py target/release/burstscope

Each picture is the first frame of a synthetic burst without noise, rounded to 8 bit; tests/goldens/own.rs makes the
same. A line is x, y, scale and orientation as COLMAP has them (the centre of the first pixel is at 0.5), then the
descriptor in hexadecimal (L1-root, UBC order). Numbers alone are kept, no picture.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import pycolmap
from PIL import Image

HERE = pathlib.Path(__file__).parent
PICTURES = {
    "scene": ["scene", "--width", "320", "--height", "240", "--frames", "1", "--snr", "inf", "--seed", "20"],
    "fields": ["scene", "--width", "300", "--height", "260", "--frames", "1", "--snr", "inf", "--seed", "33"],
}


def options(first_octave):
    o = pycolmap.SiftExtractionOptions()
    o.first_octave = first_octave
    o.num_octaves = 16
    o.octave_resolution = 3
    o.peak_threshold = 0.02 / 3
    o.edge_threshold = 10.0
    o.max_num_orientations = 4
    o.max_num_features = 100000
    return o


def main():
    program = sys.argv[1]
    for name, arguments in PICTURES.items():
        with tempfile.TemporaryDirectory() as home:
            subprocess.run([program, "synth", *arguments, "--out", f"{home}/burst", "--quiet"], check=True)
            words = np.asarray(Image.open(f"{home}/burst/frame_000.png")).astype(np.float64)
        picture = np.floor(words / 257.0 + 0.5).astype(np.uint8)
        for first_octave in (0, -1):
            keypoints, descriptors = extract(picture, options(first_octave))
            lines = [
                " ".join(repr(float(f"{np.float32(x):.6g}")) for x in keypoint[:4]) + " " + bytes(descriptor).hex()
                for keypoint, descriptor in zip(keypoints, descriptors)
            ]
            (HERE / f"{name}_{first_octave}.txt").write_text("\n".join(lines) + "\n")
            print(name, first_octave, len(lines))


def extract(picture, sift_options):
    options = pycolmap.FeatureExtractionOptions()
    options.sift = sift_options
    keypoints, descriptors = pycolmap.Sift(options, pycolmap.Device.cpu).extract(picture)
    # They come as parts of 512.
    return np.asarray(keypoints), np.rint(np.asarray(descriptors) * 512).astype(np.uint8)


main()
