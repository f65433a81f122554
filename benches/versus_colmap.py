#!/usr/bin/env python3
"""Puts COLMAP's estimator and mapper to work on a database that 'burstscope colmap' wrote.

For each pair of images COLMAP's fundamental matrix (LO-RANSAC) is estimated from the same putative matches, with the same largest error, and its inliers stand beside ours. Then
COLMAP's incremental mapper runs. Needs the Python packages numpy and pycolmap.

    burstscope colmap DATASET --out rec
    python3 benches/versus_colmap.py rec [SPARSE_DIR]
"""

import os
import sys
import tempfile

import numpy as np
import pycolmap

MAX_ERROR_PX = 4.0
MIN_INLIERS = 15


def inliers(database):
    """Rows of (ids, matches, our inliers, COLMAP's inliers)."""
    images = sorted(database.read_all_images(), key=lambda i: i.image_id)
    keypoints = {i.image_id: np.asarray(database.read_keypoints(i.image_id))[:, :2] for i in images}
    options = pycolmap.RANSACOptions()
    options.max_error = MAX_ERROR_PX
    options.random_seed = 0
    for a in images:
        for b in images:
            ids = (a.image_id, b.image_id)
            if a.image_id >= b.image_id or not database.exists_matches(*ids):
                continue
            matches = np.asarray(database.read_matches(*ids))
            ours = len(np.asarray(database.read_two_view_geometry(*ids).inlier_matches))
            points = (keypoints[i][matches[:, side]].astype(float) for side, i in enumerate(ids))
            found = pycolmap.estimate_fundamental_matrix(*points, options) if len(matches) >= 7 else None
            theirs = found["num_inliers"] if found else 0
            yield ids, len(matches), ours, theirs if theirs >= MIN_INLIERS else 0


def main():
    folder = sys.argv[1]
    path = os.path.join(folder, "database.db")
    rows = list(inliers(pycolmap.Database.open(path)))
    print(f"{'pair':>8}{'matches':>9}{'ours':>7}{'COLMAP':>8}")
    for ids, matches, ours, theirs in rows:
        print(f"{ids[0]:>4}–{ids[1]:<3}{matches:>9}{ours:>7}{theirs:>8}")
    ours, theirs = (sum(row[k] for row in rows) for k in (2, 3))
    more = sum(row[2] >= row[3] for row in rows)
    print(f"all: {ours} and {theirs} inliers; ours are as many or more in {more} of {len(rows)} pairs")
    with tempfile.TemporaryDirectory() as temporary:
        sparse = sys.argv[2] if len(sys.argv) > 2 else temporary
        os.makedirs(sparse, exist_ok=True)
        models = pycolmap.incremental_mapping(path, os.path.join(folder, "images"), sparse)
        for k, model in models.items():
            print(f"model {k}: {model.num_reg_images()} images, {model.num_points3D()} points, "
                  f"track length {model.compute_mean_track_length():.2f}, reprojection error {model.compute_mean_reprojection_error():.3f} px")


if __name__ == "__main__":
    main()
