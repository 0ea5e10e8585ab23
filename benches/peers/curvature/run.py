"""Times the published curvature flow in PyTorch on the CPU and ours, by turns."""

import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
DX, EPS, XI, SIGMA, MASS = 0.01, 0.02, 1e-6, 2.0, -0.6
TUBES = (1.0, 2.0, 6.0, -40.0, -40.0, 400.0)


def blur(torch, v):
    """Gaussian of SIGMA voxels along each axis, by the spectrum of its truncated taps."""
    for axis, n in enumerate(v.shape):
        j = torch.arange(n, dtype=v.dtype) - n // 2
        taps = torch.exp(-(j**2) / (2 * SIGMA**2))
        spectrum = torch.fft.fft(torch.roll(taps / taps.sum(), -(n // 2)))
        shape = [1, 1, 1]
        shape[axis] = n
        v = torch.fft.ifft(torch.fft.fft(v, dim=axis) * spectrum.view(shape), dim=axis).real
    return v


def phase(torch, a):
    def central(f, axis):
        return (torch.roll(f, -1, axis) - torch.roll(f, 1, axis)) / (2 * DX)

    return blur(torch, sum(central(a[i], i) for i in range(3)) + MASS)


def energy(torch, u, coefficients=TUBES):
    """Equation (20): a20 k1^2 + a11 k1 k2 + a02 k2^2 + b10 k1 + b01 k2 + c as a phase field."""
    a20, a11, a02, b10, b01, c = coefficients

    def near(f, shifts):
        for axis, shift in shifts:
            f = torch.roll(f, -shift, axis)
        return f

    g = [(near(u, [(i, 1)]) - near(u, [(i, -1)])) / (2 * DX) for i in range(3)]
    second = [(near(u, [(i, 1)]) + near(u, [(i, -1)]) - 2 * u) / DX**2 for i in range(3)]
    mixed = {}
    for i, j in ((0, 1), (0, 2), (1, 2)):
        corner = [near(u, [(i, s), (j, t)]) * s * t for s in (1, -1) for t in (1, -1)]
        mixed[i, j] = sum(corner) / (4 * DX**2)
    q = sum(x * x for x in g)
    r = q + XI**2
    n = torch.sqrt(r)
    w = u**3 - u
    along = sum(second[i] * g[i] ** 2 for i in range(3))
    along = (along + 2 * sum(mixed[i, j] * g[i] * g[j] for i, j in mixed)) / r
    squares = sum(h * h for h in second) + 2 * sum(h * h for h in mixed.values())
    trace = -EPS * sum(second) + w / EPS
    m2 = EPS**2 * squares + w**2 / EPS**2 - 2 * w * along
    d = 2 * m2 - trace**2
    xi = 1e-6
    s = torch.sqrt(xi + torch.clamp(d, min=0) + xi * torch.log1p(torch.exp(-torch.abs(d) / xi)))
    density = (a20 + a02 - a11) / (2 * EPS) * m2 + (a20 - a02) / (2 * EPS) * trace * s
    density = density + a11 / (2 * EPS) * trace**2 + (b10 + b01) / 2 * n * trace
    density = density + (b10 - b01) / 2 * n * s + c * EPS * q
    return DX**3 * density.sum()


def step_seconds(n, threads, steps):
    import torch

    torch.set_num_threads(threads)
    torch.manual_seed(1)
    a = (40 * DX * torch.rand(3, n, n, n)).requires_grad_(True)
    adam = torch.optim.Adam([a], lr=1e-3, eps=1e-2)
    seconds = []
    for _ in range(steps + 1):
        start = time.perf_counter()
        adam.zero_grad()
        energy(torch, phase(torch, a)).backward()
        adam.step()
        seconds.append(time.perf_counter() - start)
    return sorted(seconds[1:])[steps // 2]


def ours():
    lines = subprocess.check_output(["cargo", "bench", "--bench", "curvature"], cwd=HERE, text=True)
    rows = [line.split("\t") for line in lines.splitlines() if line.startswith("paper step")]
    return {1: float(rows[0][2]) * 1e-3, 2: float(rows[0][4]) * 1e-3}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--venv", help="folder of the virtual environment")
    parser.add_argument("--size", type=int, default=100)
    parser.add_argument("--steps", type=int, default=8, help="of a turn of PyTorch's")
    parser.add_argument("--rounds", type=int, default=3, help="turns of each, at least 1")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if not args.inside:
        folder = args.venv or os.path.join(tempfile.gettempdir(), "patterns-curvature-peer")
        python = os.path.join(folder, "bin", "python")
        if not os.path.exists(python):
            subprocess.check_call([sys.executable, "-m", "venv", folder])
            requirements = str(HERE / "requirements.txt")
            subprocess.check_call([python, "-m", "pip", "install", "-q", "-r", requirements])
        sys.exit(subprocess.call([python, __file__, "--inside", *sys.argv[1:]]))
    print("round  threads  PyTorch s/step  ours s/step  ratio", flush=True)
    ratios = {1: [], 2: []}
    for turn in range(max(args.rounds, 1)):
        mine = ours() if args.size == 100 else {}
        for threads in ratios:
            theirs = step_seconds(args.size, threads, args.steps)
            own = mine.get(threads, float("nan"))
            ratios[threads].append(theirs / own)
            row = f"{turn:5}  {threads:7}  {theirs:14.3f}  {own:11.4f}  {theirs / own:5.1f}"
            print(row, flush=True)
    for threads, all_ratios in ratios.items():
        print(f"median on {threads}: {statistics.median(all_ratios):.1f}")


if __name__ == "__main__":
    main()
