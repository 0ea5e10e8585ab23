#!/usr/bin/env python3
"""Fillings of Turing patterns with holes: OpenCV, scikit-image, patch copy and ours in one run.

Makes a virtual environment (--venv DIR, default a temporary folder) with the pinned packages,
runs `cargo bench --bench filling`, which writes pictures, masks and our fillings,
fills the same pictures with the peers and prints one table: ink IoU, accuracy and SSIM in the
holes, accuracy by depth, components (of at least 4 pixels) and their mean area.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
DEPTHS = [0, 2, 4, 8, 16, 32]
RINGS = [f"{a}-{b}" for a, b in zip(DEPTHS, DEPTHS[1:])]


def telea(cv2, np, picture, hidden):
    return inpaint(cv2, np, picture, hidden, cv2.INPAINT_TELEA)


def navier_stokes(cv2, np, picture, hidden):
    return inpaint(cv2, np, picture, hidden, cv2.INPAINT_NS)


def inpaint(cv2, np, picture, hidden, method):
    grey = np.round(255 * picture).astype(np.uint8)
    return cv2.inpaint(grey, hidden.astype(np.uint8), 3, method) / 255.0


def biharmonic(cv2, np, picture, hidden):
    from skimage.restoration import inpaint_biharmonic

    return inpaint_biharmonic(np.where(hidden, 0.0, picture), hidden, split_into_regions=True)


def patch_copy(cv2, np, picture, hidden, p=11):
    """Efros & Leung 1999: pixel by pixel from the rim, the best of all visible patches."""
    from numpy.lib.stride_tricks import sliding_window_view

    h = p // 2
    known = ~hidden
    padded = np.pad(np.where(known, picture, 0.0), h)
    mask = np.pad(known, h)
    whole = sliding_window_view(np.pad(known, h), (p, p)).all(axis=(2, 3))
    sources = sliding_window_view(padded, (p, p))[whole].reshape(-1, p * p).astype(np.float32)
    squares, middles = sources**2, picture[whole]
    x = np.arange(p) - h
    gauss = np.exp(-(x[:, None] ** 2 + x[None] ** 2) / (2 * (p / 6.4) ** 2)).ravel().astype(np.float32)
    while not mask[h:-h, h:-h].all():
        counts = sliding_window_view(mask, (3, 3)).sum(axis=(2, 3))[h - 1 : 1 - h, h - 1 : 1 - h]
        open_ = np.argwhere(~mask[h:-h, h:-h] & (counts > 0))
        order = np.argsort([-counts[j, i] for j, i in open_], kind="stable")
        for j, i in open_[order]:
            weight = mask[j : j + p, i : i + p].ravel() * gauss
            target = padded[j : j + p, i : i + p].ravel().astype(np.float32)
            cost = squares @ weight - 2 * sources @ (weight * target)
            padded[j + h, i + h] = middles[np.argmin(cost)]
            mask[j + h, i + h] = True
    return padded[h:-h, h:-h]


PEERS = {
    "OpenCV Telea": telea,
    "OpenCV Navier-Stokes": navier_stokes,
    "scikit-image biharmonic": biharmonic,
    "patch copy, p = 11": patch_copy,
}


def components(np, ink):
    from skimage.measure import label

    sizes = np.bincount(label(ink, connectivity=1).ravel())[1:]
    sizes = sizes[sizes >= 4]
    return len(sizes), sizes.mean() if len(sizes) else 0.0


def score(np, truth, found, hidden, depth):
    from skimage.metrics import structural_similarity

    both, either = (truth & found & hidden).sum(), ((truth | found) & hidden).sum()
    right = truth == found
    _, similarity = structural_similarity(
        truth.astype(float), found.astype(float), data_range=1.0, full=True
    )
    rings = [hidden & (depth > a) & (depth <= b) for a, b in zip(DEPTHS, DEPTHS[1:])]
    by_depth = [right[ring].mean() if ring.any() else np.nan for ring in rings]
    values = [both / max(either, 1), right[hidden].mean(), similarity[hidden].mean()]
    return values + by_depth + list(components(np, found & hidden))


def measure(folder):
    import cv2
    import numpy as np
    from scipy.ndimage import distance_transform_edt

    cv2.setNumThreads(1)
    table = {}
    for ink_file in sorted(folder.glob("*-ink.npy")):
        pattern, hole, seed, _ = ink_file.stem.split("-")
        read = lambda part: np.load(folder / f"{pattern}-{hole}-{seed}-{part}.npy")
        truth, hidden, grey = read("ink") > 0.5, read("visible") < 0.5, read("grey")
        depth = distance_transform_edt(hidden)
        # The grey level of the border between ink and paper.
        level = 0.5 * (grey[truth].max() + grey[~truth].min())
        rows = {"truth": truth, "ink everywhere": np.ones_like(truth), "paper everywhere": ~np.ones_like(truth)}
        for kind, picture, border in [("grey", grey, level), ("binary", 1.0 - truth, 0.5)]:
            for name, peer in PEERS.items():
                rows[f"{name}, {kind}"] = peer(cv2, np, picture, hidden) < border
            rows[f"our patches, {kind}"] = read(f"patch_{kind}") > 0.5
            rows[f"ours, {kind}"] = read(f"ours_{kind}_0") > 0.5
        for name, found in rows.items():
            found = np.where(hidden, found, truth)
            table.setdefault((pattern, hole), {}).setdefault(name, []).append(
                score(np, truth, found, hidden, depth)
            )
    for (pattern, hole), rows in table.items():
        print(f"\n{pattern}, {hole} hole(s), mean of {len(rows['truth'])} seeds")
        depths = "".join(f"{text:>7}" for text in RINGS)
        print(f"{'':32}{'IoU':>6}{'acc':>6}{'SSIM':>6} | depth:{depths} | {'parts':>6}{'area':>6}")
        for name, values in rows.items():
            iou, accuracy, ssim, *by_depth, count, area = np.mean(values, axis=0)
            rings = "".join("      -" if np.isnan(v) else f"{v:7.2f}" for v in by_depth)
            print(
                f"{name:32}{iou:6.2f}{accuracy:6.2f}{ssim:6.2f} |       {rings} | {count:6.1f}{area:6.1f}"
            )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--venv", help="folder of the virtual environment")
    parser.add_argument("--seeds", default="3", help="patterns of each kind [default: 3]")
    parser.add_argument("--folder", help="where pictures and fillings are kept")
    parser.add_argument("--measure", type=pathlib.Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        return measure(args.measure)
    with tempfile.TemporaryDirectory() as temporary:
        venv = pathlib.Path(args.venv or temporary) / "venv"
        if not venv.exists():
            subprocess.run([sys.executable, "-m", "venv", venv], check=True)
            pip = [venv / "bin" / "pip", "install", "-q", "-r", HERE / "requirements.txt"]
            subprocess.run(pip, check=True)
        folder = pathlib.Path(args.folder or temporary) / "filling"
        ours = ["cargo", "bench", "-q", "--bench", "filling", "--", folder, args.seeds]
        subprocess.run(ours, check=True, cwd=ROOT)
        subprocess.run([venv / "bin" / "python", __file__, "--measure", folder], check=True)


if __name__ == "__main__":
    main()
