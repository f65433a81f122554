"""Finds and matches the features of two bursts, and hands them to OpenCV where it is installed."""

from __future__ import annotations

import sys

import burstscope as bs


def main(first: str = "demo", second: str = "demo-later") -> None:
    """Matches the bursts at two paths; without paths the two that are built in."""
    detections = [bs.detect(bs.open(path), slopes_u=(-3, 3, 13), noise_gate="matching") for path in (first, second)]
    matched = bs.match(*detections)
    print(matched)
    if matched.inliers is not None:
        moved = matched.aligned_b[matched.inliers] - matched.aligned_a[matched.inliers]
        print("mean motion from the first to the second:", [round(float(x), 2) for x in moved.mean(0)], "px")
    try:
        keypoints, descriptors = detections[0].to_cv2()
    except ImportError:
        print("for OpenCV's keypoints: pip install opencv-python-headless")
    else:
        print(len(keypoints), "keypoints for OpenCV, descriptors", descriptors.shape)


if __name__ == "__main__":
    main(*sys.argv[1:])
