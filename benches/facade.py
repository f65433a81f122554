#!/usr/bin/env python3
"""Makes a dataset of dark bursts of a court whose walls have rows of equal windows, with known cameras.

A match of two windows agrees with its neighbours and in its picture, whichever windows they are: the scene asks
whether a wrong one is recognised. The folder is laid out like those of ../shared/reconstruct, whose scripts score it;
its noise is theirs. It needs numpy and opencv-python-headless.

    python3 benches/facade.py OUT --seed 1 --white-e 10 --views 12 --shared ../shared
"""

import argparse
import json
import pathlib
import sys

import cv2
import numpy as np

TEXELS_PER_M = 70
WIDTH, HEIGHT, FOCAL_PX = 1152, 768, 900.0
FRAMES, MAX_SLOPE, READ_E = 10, 3.0, 2.0
# Distance of neighbouring windows; for each row the depth of their tops below the wall's edge, m, and their kind.
PITCH_M, ROWS = 1.9, [(0.6, 0), (3.4, 1), (6.2, 0)]


def weathered(rng, height, width, finest=1.0):
    """A texture with details of all sizes, standard deviation 1."""
    total, size = np.zeros((height, width), np.float32), finest
    while size < 200:
        coarse = rng.normal(size=(int(height / size) + 3, int(width / size) + 3)).astype(np.float32)
        total += cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC) * size**0.35
        size *= 2
    return total / total.std()


def window(rng, height, width):
    """A window with bars in a frame that has ornaments above."""
    picture = np.full((height, width), 0.75, np.float32)
    edge = max(6, width // 10)
    picture[edge:-edge, edge:-edge] = 0.12 + 0.03 * weathered(rng, height - 2 * edge, width - 2 * edge)
    for i in (1, 2):
        u = edge + (width - 2 * edge) * i // 3
        picture[edge:-edge, u - 2 : u + 2] = 0.6
    for i in (1, 2, 3, 4):
        v = edge + (height - 2 * edge) * i // 5
        picture[v - 2 : v + 2, edge:-edge] = 0.6
    picture += 0.05 * weathered(rng, height, width)
    for _ in range(10):
        place = (int(rng.integers(4, width - 4)), int(rng.integers(2, edge + 2)))
        cv2.circle(picture, place, int(rng.integers(2, 5)), float(rng.uniform(0.1, 1)), -1)
    return picture


def wall(rng, width_m, height_m, windows):
    """A wall with equal windows, unlike only by what time did to the plaster, and some doors."""
    width, height = int(width_m * TEXELS_PER_M), int(height_m * TEXELS_PER_M)
    picture = 0.45 + 0.05 * weathered(rng, height, width, 2)
    for top_m, kind in ROWS:
        tall, wide = windows[kind].shape
        for i in range(int((width_m - 1.0) // PITCH_M)):
            u, v = int((0.9 + i * PITCH_M) * TEXELS_PER_M), int(top_m * TEXELS_PER_M)
            if v + tall < height and u + wide < width:
                picture[v : v + tall, u : u + wide] = windows[kind] * rng.uniform(0.95, 1.05) + 0.01 * weathered(rng, tall, wide)
    for _ in range(int(width_m / 8)):
        u, v = int(rng.uniform(1, width_m - 3) * TEXELS_PER_M), int((height_m - 2.2) * TEXELS_PER_M)
        door = picture[v : v + 2 * TEXELS_PER_M, u : u + TEXELS_PER_M + 20]
        door[:] = 0.3 + 0.12 * weathered(rng, *door.shape, 2)
    return np.clip(picture, 0.02, 1.2)


def court(rng):
    """Planes, each with its corner, the directions of its columns and rows, and its texture; metres, y downwards."""
    size = lambda tall, wide: (int(tall * TEXELS_PER_M), int(wide * TEXELS_PER_M))
    windows = [window(rng, *size(1.9, 1.1)), window(rng, *size(2.0, 1.2))]
    front, left, right = (wall(rng, width_m, 9, windows) for width_m in (30, 16, 16))
    ground = np.clip(0.35 + 0.05 * weathered(rng, 16 * TEXELS_PER_M, 30 * TEXELS_PER_M, 3), 0.02, 1)
    planes = [
        ((0, -9, 0), (1, 0, 0), (0, 1, 0), front),
        ((0, -9, -16), (0, 0, 1), (0, 1, 0), left),
        ((30, -9, 0), (0, 0, -1), (0, 1, 0), right),
        ((0, 0, 0), (1, 0, 0), (0, 0, -1), ground),
    ]
    return [(*(np.array(vector, float) for vector in plane[:3]), plane[3]) for plane in planes]


def seen(planes, rays, rotation, translation):
    """What a camera sees, and the inverse depth of each pixel; 0 in the sky."""
    centre, directions = -rotation.T @ translation, rays @ rotation
    depth, picture = np.full(rays.shape[:2], np.inf), np.full(rays.shape[:2], 0.9, np.float32)
    for corner, across, down, texture in planes:
        normal = np.cross(across, down)
        slant = directions @ normal
        far = np.where(np.abs(slant) > 1e-9, ((corner - centre) @ normal) / np.where(np.abs(slant) > 1e-9, slant, 1), np.inf)
        place = centre + directions * np.where(np.isfinite(far), far, 0)[..., None] - corner
        u, v = place @ across * TEXELS_PER_M, place @ down * TEXELS_PER_M
        hit = (far > 0.1) & (far < depth) & (u >= 0) & (v >= 0) & (u < texture.shape[1]) & (v < texture.shape[0])
        if not hit.any():
            continue
        texels = np.median(far[hit]) / FOCAL_PX * TEXELS_PER_M
        smooth = cv2.GaussianBlur(texture, (0, 0), max(0.3, 0.5 * texels))
        at = ((u - 0.5).astype(np.float32), (v - 0.5).astype(np.float32))
        sampled = cv2.remap(smooth, *at, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        picture, depth = np.where(hit, sampled, picture), np.where(hit, far, depth)
    return picture, 1 / depth


def views(rng, count):
    """Names and poses (world to camera) of cameras that walk through the court and look at its front."""
    found = []
    for i in range(count):
        way = i / (count - 1)
        off = rng.uniform(-0.4, 0.4), rng.uniform(-0.2, 0.2), rng.uniform(-0.5, 0.5)
        centre = np.array([5 + 20 * way + off[0], -1.7 + off[1], -10.5 + 2.5 * np.sin(np.pi * way) + off[2]])
        ahead = np.array([7 + 16 * way + rng.uniform(-1.5, 1.5), -4.2, 0]) - centre
        ahead /= np.linalg.norm(ahead)
        across = np.cross(np.array([0, 1.0, 0]), ahead)
        across /= np.linalg.norm(across)
        rotation = np.array([across, np.cross(ahead, across), ahead])
        found.append((f"v{i:02d}", rotation, -rotation @ centre))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--white-e", type=float, default=10.0, help="electrons at scene white")
    parser.add_argument("--views", type=int, default=12)
    parser.add_argument("--shared", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2] / "shared")
    args = parser.parse_args()
    if args.views < 2 or args.seed < 0 or not args.white_e > 0:
        parser.error("give --views from 2, --seed from 0, and --white-e above 0")
    if not (args.shared / "reconstruct" / "common.py").is_file():
        parser.error(f"--shared: no reconstruct/common.py in {args.shared}; name the folder with the scoring scripts")
    sys.path.insert(0, str(args.shared / "reconstruct"))
    import common

    for folder in ("bursts", "truth"):
        (args.out / folder).mkdir(parents=True, exist_ok=True)
    camera = {"model": "PINHOLE", "width": WIDTH, "height": HEIGHT, "params": [FOCAL_PX, FOCAL_PX, WIDTH / 2, HEIGHT / 2]}
    rays = common.Cam(camera).rays(common.grid(WIDTH, HEIGHT))
    rays = np.concatenate([rays, np.ones((HEIGHT, WIDTH, 1))], -1)
    rng = np.random.default_rng(args.seed)
    planes, poses, middle, bursts = court(rng), views(rng, args.views), (FRAMES - 1) / 2, []
    for name, rotation, translation in poses:
        _, inverse_depth = seen(planes, rays, rotation, translation)
        speed = MAX_SLOPE / (FOCAL_PX * inverse_depth.max())
        noise, frame_poses = common.rng_for(args.seed, "facade", name, f"{args.white_e:g}"), []
        (args.out / "bursts" / name).mkdir(exist_ok=True)
        for t in range(FRAMES):
            moved = translation - (t - middle) * speed * np.array([1.0, 0, 0])
            frame_poses.append([rotation.tolist(), moved.tolist()])
            picture, _ = seen(planes, rays, rotation, moved)
            frame = common.expose(picture, args.white_e, READ_E, noise)
            cv2.imwrite(str(args.out / "bursts" / name / f"frame_{t:03d}.png"), frame)
        np.savez_compressed(args.out / "truth" / f"{name}.npz", inv_depth=inverse_depth.astype(np.float32))
        bursts.append({"name": name, "R": rotation.tolist(), "t": translation.tolist(), "frame_poses": frame_poses})
        print(name, flush=True)
    noise = {"white_e": args.white_e, "read_e": READ_E, "gain": common.GAIN, "black": common.BLACK}
    scene = {"name": args.out.name, "scene": "facade", "mode": "1d", "frames": FRAMES, "t0": middle, "width": WIDTH, "height": HEIGHT, "camera": camera}
    scoring = {"units": "m", "fix_intrinsics": False, "first_octave": 0, "max_slope": MAX_SLOPE, "seed": args.seed, "real_motion": False, "noise": noise}
    (args.out / "meta.json").write_text(json.dumps({**scene, **scoring, "bursts": bursts}, indent=1))


if __name__ == "__main__":
    main()
