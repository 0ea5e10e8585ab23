#!/usr/bin/env python3
"""Signed distance of a 1024 x 1024 circle: scikit-fmm, scipy, OpenCV and this project in one run.

Prints CPU seconds of one thread (best of several) and errors in cells, next to the
contour (|d| < 1.5) and anywhere. Run from anywhere: it makes a virtual environment
(--venv DIR, default a temporary folder) with the pinned packages and starts itself
in it, then runs `cargo bench --bench redistance`.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile
import time
import venv

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
N = 1024


def best(f, repeats=5):
    """Best wall and CPU seconds, and the last result."""
    walls, times = [], []
    for _ in range(repeats):
        start, busy = time.perf_counter(), time.process_time()
        result = f()
        walls.append(time.perf_counter() - start)
        times.append(time.process_time() - busy)
    return min(walls), min(times), result


def measure():
    import cv2
    import numpy as np
    import scipy.ndimage
    import skfmm

    cv2.setNumThreads(1)
    y, x = np.mgrid[:N, :N].astype(float)
    center, radius = 0.5 * N - 0.3, 0.3 * N
    exact = np.hypot(x - center, y - 0.9 - center) - radius
    near = np.abs(exact) < 1.5
    smooth = np.hypot(x - center, y - 0.9 - center) ** 2 - radius**2
    inside = exact < 0

    def two_sided(transform):
        return transform(~inside) - transform(inside) + np.where(inside, 0.5, -0.5)

    def opencv(mask):
        return cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5).astype(float)

    engines = {
        "scikit-fmm order 1": lambda: skfmm.distance(smooth, order=1),
        "scikit-fmm order 2": lambda: skfmm.distance(smooth, order=2),
        "scikit-fmm order 2, narrow 6": lambda: np.ma.filled(skfmm.distance(smooth, order=2, narrow=6), np.nan),
        "scipy EDT": lambda: two_sided(scipy.ndimage.distance_transform_edt),
        "OpenCV 5x5": lambda: two_sided(opencv),
    }
    for name, f in engines.items():
        wall, cpu, d = best(f)
        error = np.abs(d - exact)
        values = error[near]
        print(
            f"{name}\tx^2+y^2-r^2\t1\t{wall * 1e3:.2f}\t{cpu * 1e3:.2f}\t{values.max():.5f}"
            f"\t{values.mean():.6f}\t{np.nanmax(error):.4f}",
            flush=True,
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--venv", help="folder of the virtual environment, kept (default: temporary)")
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        return measure()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(options.venv or temporary)
        python = folder / "bin" / "python"
        if not python.exists():
            venv.create(folder, with_pip=True)
            requirements = HERE / "requirements.txt"
            subprocess.run([python, "-m", "pip", "install", "-q", "-r", requirements], check=True)
        subprocess.run(["cargo", "bench", "-q", "--bench", "redistance", "--no-run"], cwd=ROOT, check=True)
        print("engine\tinput\tthreads\twall_ms\tcpu_ms\tnear_max\tnear_mean\tfar_max", flush=True)
        subprocess.run([python, __file__, "--measure"], check=True)
        subprocess.run(["cargo", "bench", "-q", "--bench", "redistance"], cwd=ROOT, check=True)


if __name__ == "__main__":
    sys.exit(main())
