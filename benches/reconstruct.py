#!/usr/bin/env python3
"""Reconstructs scenes from bursts taken in the dark, method by method, and prints one table.

The bursts are real pictures with known cameras, made dark; COLMAP matches, verifies and maps the features, and the cameras are compared with the true ones. The datasets and
the scoring are scripts that lie beside the project (../shared/reconstruct), the mapper is COLMAP's (pycolmap). Datasets that are missing are made in DATA; features and
every single run stay there too.

    cargo build --release
    python3 benches/reconstruct.py DATA
    python3 benches/reconstruct.py DATA --datasets door_1d_e1.2,door_2d_e1.2 --methods buff,merge,oracle --repeats 3

Methods:
    buff          burstscope detect with its defaults
    buff-grid     the same with 2·M+1 slopes from -M to M on each axis that moves, M the dataset's largest slope rounded up
    merge         burstscope detect --method merge, with its best settings (no peak threshold, two orientations)
    colmap-frame  COLMAP's SIFT on one noisy frame
    colmap-merge  COLMAP's SIFT on a burst merge of the scoring scripts' own
    oracle        COLMAP's SIFT on the mean of all frames, each warped by the true motion: what no method can know
    gold          COLMAP's SIFT on the view without noise
"""

import argparse
import importlib.util
import json
import math
import pathlib
import re
import subprocess
import sys
import time

PROJECT = pathlib.Path(__file__).resolve().parent.parent
# What makes a dataset: script, its arguments before and after the folder. The script appends the light to the name of a door.
DATASETS = {
    "door_1d_e1.2": ("make_multiview.py", ["door", "../data/lund-door"], "door_1d", ["--mode", "1d", "--white-e", "1.2"]),
    "door_2d_e1.2": ("make_multiview.py", ["door", "../data/lund-door"], "door_2d", ["--mode", "2d", "--white-e", "1.2"]),
    "slider_far_e5": ("make_slider.py", ["slider_far", "../data/slider-far"], "slider_far_e5", ["--white-e", "5"]),
    "door_1d_e2": ("make_multiview.py", ["door", "../data/lund-door"], "door_1d", ["--mode", "1d", "--white-e", "2"]),
    "door_2d_e2": ("make_multiview.py", ["door", "../data/lund-door"], "door_2d", ["--mode", "2d", "--white-e", "2"]),
    "slider_far_e10": ("make_slider.py", ["slider_far", "../data/slider-far"], "slider_far_e10", ["--white-e", "10"]),
}
OURS = ("buff", "buff-grid", "merge")
# Method of baselines.py, and the peak threshold in units of scene white.
THEIRS = {"colmap-frame": "single", "colmap-merge": "merge", "oracle": "oracle", "gold": "gold"}
PEAK = "0.0067"
COLUMNS = ("dataset", "method", "features an image", "inliers an image", "right matches an image", "images registered", "cameras right", "ATE", "s a burst")


def missing(shared, tool):
    """What is needed and not there, a line each."""
    lines = []
    scripts = shared / "reconstruct"
    if not (scripts / "evaluate.py").is_file():
        lines.append(f"the scripts that make and score the datasets: no evaluate.py in {scripts}; name their folder's parent with --shared")
    for package, name in (("numpy", "numpy"), ("scipy", "scipy"), ("cv2", "opencv-python-headless"), ("pycolmap", "pycolmap (4.2 or newer)")):
        if importlib.util.find_spec(package) is None:
            lines.append(f"the Python package {name}: pip install {name.split()[0]}")
    if not tool.is_file():
        lines.append(f"the program: no {tool}; run 'cargo build --release' first, or name it with --tool")
    return lines


def make(name, data, scripts):
    """The folder of a dataset, made if it is not there."""
    folder = data / name
    if not (folder / "meta.json").is_file():
        script, before, base, after = DATASETS[name]
        print(f"making {folder} …", file=sys.stderr, flush=True)
        command = [sys.executable, "-B", script, *before, str(data / base), *after]
        subprocess.run(command, cwd=scripts, check=True, stdout=subprocess.DEVNULL)
    if not (folder / "meta.json").is_file():
        sys.exit(f"{DATASETS[name][0]} did not write {folder / 'meta.json'}")
    return folder


def options(method, meta):
    """What burstscope detect is told beside the burst."""
    given = ["--first-octave", str(meta["first_octave"])]
    if method == "merge":
        return given + ["--method", "merge", "--peak-threshold", "0", "--max-orientations", "2"]
    if method == "buff-grid":
        m = math.ceil(meta["max_slope"])
        axis = f"{-m}:{m}:{2 * m + 1}"
        given += ["--slopes-u", axis] + (["--slopes-v", axis] if meta["mode"] == "2d" else [])
    return given


def ours(method, folder, meta, out, tool):
    """Writes the features of every burst; seconds a burst."""
    seconds = []
    for burst in meta["bursts"]:
        command = [str(tool), "detect", str(folder / "bursts" / burst["name"]), "--out", str(out), "--format", "colmap", "--quiet"]
        started = time.monotonic()
        done = subprocess.run(command + options(method, meta), capture_output=True, text=True, check=False)
        seconds.append(time.monotonic() - started)
        if done.returncode:
            sys.exit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
    return sum(seconds) / len(seconds)


def theirs(method, folder, out, scripts, images):
    """Writes the features of a baseline of the scripts."""
    command = [sys.executable, "-B", "baselines.py", str(folder), str(out), "--method", THEIRS[method], "--peak", PEAK, "--images", str(images)]
    done = subprocess.run(command, cwd=scripts, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr}")


def reference_frame(method, meta):
    """The frame whose pose a method's features have; None for the middle of the burst. A merge is aligned to one of its frames."""
    return {"merge": meta["frames"] // 2, "colmap-merge": (meta["frames"] - 1) // 2}.get(method)


def right_matches(folder, out, at, scripts):
    """Verified matches an image with a true reprojection error under 2 px, as true_matches.py counts them."""
    command = [sys.executable, "-B", "true_matches.py", str(folder), "--features", str(out)]
    command += [] if at is None else ["--time", str(at)]
    done = subprocess.run(command, cwd=scripts, capture_output=True, text=True, check=False)
    found = re.search(r"right <2 px ([0-9.]+)", done.stdout)
    if done.returncode or not found:
        sys.exit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
    return float(found.group(1))


def cells(score, method, seconds):
    """A row of the table."""
    ate = score.get("ate_trans")
    if ate is None:
        error = "–"
    elif score["units"] == "m":
        error = f"{100 * ate:.2f} cm"
    else:
        error = f"{100 * ate / score['extent']:.2f} %"
    shown = "–" if seconds is None else f"{seconds:.2f}"
    return (score["dataset"], method, f"{score['keypoints']:.0f}", f"{score['inliers']:.0f}", f"{score['right']:.0f}", f"{score['pass_pct']:.0f} %", f"{score['good_pct']:.0f} %", error, shown)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=pathlib.Path, help="folder for datasets and results, outside the project")
    parser.add_argument("--datasets", default=",".join(DATASETS), help="some of: " + ", ".join(DATASETS))
    parser.add_argument("--methods", default="buff,merge,colmap-merge,oracle", help="some of: " + ", ".join((*OURS, *THEIRS)))
    parser.add_argument("--repeats", type=int, default=3, help="runs of verification and mapper with seeds 0, 1, …; the table has their mean")
    parser.add_argument("--shared", type=pathlib.Path, default=PROJECT.parent / "shared", help="folder with reconstruct/ and data/")
    parser.add_argument("--tool", type=pathlib.Path, default=PROJECT / "target/release/burstscope", help="the program")
    arguments = parser.parse_args()
    datasets, methods = arguments.datasets.split(","), arguments.methods.split(",")
    for name, known in [(name, DATASETS) for name in datasets] + [(name, (*OURS, *THEIRS)) for name in methods]:
        if name not in known:
            parser.error(f"'{name}' is none of {', '.join(known)}")
    if arguments.repeats < 1:
        parser.error("--repeats: give 1 or more")
    shared, tool, data = arguments.shared.resolve(), arguments.tool.resolve(), arguments.data.resolve()
    if lines := missing(shared, tool):
        sys.exit("cannot run, because this is missing:\n  " + "\n  ".join(lines))
    if data.is_relative_to(PROJECT):
        parser.error(f"{data} is inside the project; name a folder outside it")
    scripts = shared / "reconstruct"
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(scripts))
    import evaluate

    print("| " + " | ".join(COLUMNS) + " |\n|" + " --- |" * len(COLUMNS), flush=True)
    for name in datasets:
        folder = make(name, data, scripts)
        meta = json.loads((folder / "meta.json").read_text())
        for method in methods:
            out = data / "results" / name / method
            out.mkdir(parents=True, exist_ok=True)
            seconds = None
            if method in OURS:
                seconds = ours(method, folder, meta, out, tool)
            else:
                theirs(method, folder, out, scripts, data / "results" / "images")
            at = reference_frame(method, meta)
            runs = [evaluate.run(folder, out, method, at, seed=seed) for seed in range(arguments.repeats)]
            score = evaluate.average(runs)
            score["right"] = right_matches(folder, out, at, scripts)
            (out / "score.json").write_text(json.dumps(score, indent=1))
            print("| " + " | ".join(cells(score, method, seconds)) + " |", flush=True)


if __name__ == "__main__":
    main()
