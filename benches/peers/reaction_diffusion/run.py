"""Times Gray-Scott (five-point Laplacian, periodic, f64, one thread) in Python's tools, then ours."""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
FEED, KILL, DU, DV = 0.058, 0.063, 0.2097152, 0.1048576


def best(work, updates, repetitions=5):
    seconds = []
    for _ in range(repetitions):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return updates / min(seconds) / 1e6


def start(np, n):
    u, v = np.ones((n, n)), np.zeros((n, n))
    u[n // 3 : n // 2, n // 3 : n // 2] = 0.5
    v[n // 3 : n // 2, n // 3 : n // 2] = 0.25
    return u, v


def numpy_roll(np, n, steps):
    u, v = start(np, n)

    def lap(a):
        return np.roll(a, 1, 0) + np.roll(a, -1, 0) + np.roll(a, 1, 1) + np.roll(a, -1, 1) - 4 * a

    def work():
        nonlocal u, v
        for _ in range(steps):
            r = u * v * v
            u, v = u + DU * lap(u) - r + FEED * (1 - u), v + DV * lap(v) + r - (FEED + KILL) * v

    return best(work, n * n * steps)


def numba_kernel(np, n, steps):
    import numba

    @numba.njit
    def advance(u, v, un, vn, steps):
        ny, nx = u.shape
        for _ in range(steps):
            for j in range(ny):
                north, south = (j - 1) % ny, (j + 1) % ny
                for i in range(nx):
                    west, east = i - 1 if i > 0 else nx - 1, i + 1 if i < nx - 1 else 0
                    a, b = u[j, i], v[j, i]
                    lu = u[north, i] + u[south, i] + u[j, west] + u[j, east] - 4 * a
                    lv = v[north, i] + v[south, i] + v[j, west] + v[j, east] - 4 * b
                    r = a * b * b
                    un[j, i] = a + DU * lu - r + FEED * (1 - a)
                    vn[j, i] = b + DV * lv + r - (FEED + KILL) * b
            u, un = un, u
            v, vn = vn, v

    u, v = start(np, n)
    un, vn = u.copy(), v.copy()
    advance(u, v, un, vn, 1)
    return best(lambda: advance(u, v, un, vn, steps), n * n * steps)


def py_pde(np, n, steps):
    import pde

    equation = pde.PDE(
        {
            "u": f"{DU} * laplace(u) - u * v**2 + {FEED} * (1 - u)",
            "v": f"{DV} * laplace(v) + u * v**2 - {FEED + KILL} * v",
        }
    )
    grid = pde.CartesianGrid([[0, n], [0, n]], n, periodic=True)
    u, v = start(np, n)
    state = pde.FieldCollection([pde.ScalarField(grid, u), pde.ScalarField(grid, v)])

    def run(count):
        equation.solve(state, t_range=count, dt=1, adaptive=False, tracker=None)

    run(1)  # compiles; each call compiles again, so the cost of a call is taken off
    start_time = time.perf_counter()
    run(1)
    call = time.perf_counter() - start_time
    start_time = time.perf_counter()
    run(steps)
    return n * n * (steps - 1) / max(time.perf_counter() - start_time - call, 1e-9) / 1e6


def measure():
    import numpy as np

    print(f"{'numpy roll, 1024^2':28} {numpy_roll(np, 1024, 10):8.0f} Mcell/s")
    print(f"{'numba kernel, 1024^2':28} {numba_kernel(np, 1024, 50):8.0f} Mcell/s")
    print(f"{'py-pde, 256^2':28} {py_pde(np, 256, 2000):8.0f} Mcell/s", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--venv", help="folder of the virtual environment")
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        return measure()
    with tempfile.TemporaryDirectory() as temporary:
        venv = pathlib.Path(args.venv or temporary) / "venv"
        if not venv.exists():
            subprocess.run([sys.executable, "-m", "venv", venv], check=True)
            pip = [venv / "bin" / "pip", "install", "-q", "-r", HERE / "requirements.txt"]
            subprocess.run(pip, check=True)
        one_thread = {"OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
        environment = os.environ | one_thread
        subprocess.run([venv / "bin" / "python", __file__, "--measure"], check=True, env=environment)
    root = HERE.parents[2]
    subprocess.run(["cargo", "bench", "--bench", "reaction_diffusion"], check=True, cwd=root)


if __name__ == "__main__":
    main()
