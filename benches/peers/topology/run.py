#!/usr/bin/env python3
"""SIMP on the MBB beam of 300 x 100 elements: a port of top88, pyMOTO and this project in one run.

Prints CPU seconds of an iteration (one thread, mean over iterations 11 to 30, best of
several runs), after checking the port against the figures of top88 itself. Run from
anywhere: it makes a virtual environment (--venv DIR, default a temporary folder) with
the pinned packages and starts itself in it, each engine in its own process, then runs
`cargo run --release -- bench topopt`.
"""

import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import venv
import warnings

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
NELX, NELY, VOLFRAC, PENAL, RMIN = 300, 100, 0.5, 3.0, 4.0
E0, EMIN, NU, MOVE = 1.0, 1e-9, 0.3, 0.2
WARM, LAST = 10, 30
SCIKIT_SPARSE = "scikit-sparse==0.4.16"
# Compliances of top88 run in Octave: iteration 50 of the beam above; top88(60,20,.5,3,1.5) at its end.
BEAM_50, SMALL_END, SMALL_ITERATIONS = 198.4735, 203.1925, 94


def element_stiffness(np):
    a11 = np.array([[12, 3, -6, -3], [3, 12, 3, 0], [-6, 3, 12, -3], [-3, 0, -3, 12]])
    a12 = np.array([[-6, -3, 0, 3], [-3, -6, -3, -6], [0, -3, -6, 3], [3, -6, 3, -6]])
    b11 = np.array([[-4, 3, -2, 9], [3, -4, -9, 4], [-2, -9, -4, -3], [9, 4, -3, -4]])
    b12 = np.array([[2, -3, 4, -9], [-3, 2, 9, -2], [4, 9, 2, 3], [-9, -2, 3, 2]])
    a, b = np.block([[a11, a12], [a12.T, a11]]), np.block([[b11, b12], [b12.T, b11]])
    return (a + NU * b) / (1 - NU**2) / 24


def nested_dissection(np, nx, ny):
    """Nodes of an nx x ny grid (y fastest): both halves first, then the line between them."""
    number = np.arange(nx * ny).reshape(nx, ny)
    parts = []

    def order(block):
        if block.size <= 16:
            parts.append(block.ravel())
            return
        if block.shape[0] < block.shape[1]:
            block = block.T
        middle = block.shape[0] // 2
        order(block[:middle])
        order(block[middle + 1 :])
        parts.append(block[middle])

    order(number)
    return np.concatenate(parts)


class Cvxopt:
    """CHOLMOD as cvxopt has it: symbolic analysis once, supernodal numeric factorization each time."""

    def __init__(self, n, rows, columns, ordered):
        import numpy as np
        from cvxopt import cholmod, matrix, spmatrix

        self.cholmod, self.matrix, self.np = cholmod, matrix, np
        self.lower = spmatrix(1.0, matrix(rows), matrix(columns), (n, n))
        self.values = matrix(0.0, (rows.size, 1))
        cholmod.options["supernodal"] = 2
        identity = matrix(np.arange(n))
        self.factor = cholmod.symbolic(self.lower, identity) if ordered else cholmod.symbolic(self.lower)

    def solve(self, values, b):
        self.np.asarray(self.values)[:, 0] = values
        self.lower.V = self.values
        self.cholmod.numeric(self.lower, self.factor)
        x = self.matrix(b)
        self.cholmod.solve(self.factor, x)
        return self.np.asarray(x)[:, 0]


class ScikitSparse:
    """CHOLMOD as scikit-sparse has it (up to 0.4)."""

    def __init__(self, n, rows, columns, ordered):
        import numpy as np
        import scipy.sparse
        from sksparse import cholmod

        starts = np.searchsorted(columns, np.arange(n + 1))
        self.lower = scipy.sparse.csc_matrix((np.ones(rows.size), rows.astype(np.int32), starts), shape=(n, n))
        ordering = "natural" if ordered else "amd"
        self.factor = cholmod.analyze(self.lower, mode="supernodal", ordering_method=ordering)

    def solve(self, values, b):
        self.lower.data[:] = values
        self.factor.cholesky_inplace(self.lower)
        return self.factor(b)


class SuperLU:
    """scipy's splu in its symmetric mode; it has no symbolic analysis to keep."""

    def __init__(self, n, rows, columns, ordered):
        import numpy as np
        import scipy.sparse
        import scipy.sparse.linalg

        off = np.flatnonzero(rows != columns)
        slots = np.r_[np.arange(rows.size), off]
        i, j = np.r_[rows, columns[off]], np.r_[columns, rows[off]]
        sort = np.lexsort((i, j))
        self.slots, starts = slots[sort], np.searchsorted(j[sort], np.arange(n + 1))
        self.full = scipy.sparse.csc_matrix((np.ones(sort.size), i[sort], starts), shape=(n, n))
        self.ordering = "NATURAL" if ordered else "MMD_AT_PLUS_A"
        self.splu = scipy.sparse.linalg.splu

    def solve(self, values, b):
        self.full.data = values[self.slots]
        options = {"SymmetricMode": True}
        return self.splu(self.full, permc_spec=self.ordering, diag_pivot_thresh=0.0, options=options).solve(b)


def top88(engine, ordered, nelx, nely, rmin, iterations=None):
    """Compliance and CPU seconds of each iteration; without `iterations` until the change is 0.01."""
    import numpy as np
    import scipy.sparse

    ke = element_stiffness(np)
    elements, nodes = nelx * nely, (nelx + 1) * (nely + 1)
    first = (np.arange(nelx)[:, None] * (nely + 1) + np.arange(nely)).ravel()
    dofs = 2 * first[:, None] + np.array([2, 3, 2 * nely + 4, 2 * nely + 5, 2 * nely + 2, 2 * nely + 3, 0, 1])
    fixed = np.zeros(2 * nodes, bool)
    fixed[0 : 2 * (nely + 1) : 2] = True
    fixed[-1] = True
    sequence = nested_dissection(np, nelx + 1, nely + 1) if ordered else np.arange(nodes)
    free = (2 * sequence[:, None] + np.array([0, 1])).ravel()
    free = free[~fixed[free]]
    number = np.full(2 * nodes, -1)
    number[free] = np.arange(free.size)

    # Lower triangle over the free degrees of freedom: its values are `assembly` times the moduli.
    a, b = np.tril_indices(8)
    i, j = number[dofs][:, a], number[dofs][:, b]
    kept = (i >= 0) & (j >= 0)
    entries = (np.minimum(i, j) * free.size + np.maximum(i, j))[kept]
    slots, slot = np.unique(entries, return_inverse=True)
    columns, rows = np.divmod(slots, free.size)
    element = np.broadcast_to(np.arange(elements)[:, None], i.shape)[kept]
    weight = np.broadcast_to(ke[a, b], i.shape)[kept]
    assembly = scipy.sparse.csr_matrix((weight, (slot, element)), shape=(slots.size, elements))
    solver = engine(free.size, rows, columns, ordered)
    load = np.zeros(2 * nodes)
    load[1] = -1.0
    load = load[free]

    # Cone filter.
    grid, near, far, weights = np.arange(elements).reshape(nelx, nely), [], [], []
    reach = int(np.ceil(rmin)) - 1
    for dx in range(-reach, reach + 1):
        for dy in range(-reach, reach + 1):
            if rmin > np.hypot(dx, dy):
                here = grid[max(0, -dx) : nelx - max(0, dx), max(0, -dy) : nely - max(0, dy)]
                near.append(here.ravel())
                far.append((here + dx * nely + dy).ravel())
                weights.append(np.full(here.size, rmin - np.hypot(dx, dy)))
    near, far, weights = map(np.concatenate, (near, far, weights))
    cone = scipy.sparse.csr_matrix((weights, (near, far)), shape=(elements, elements))
    cone_sum = cone @ np.ones(elements)

    x, u, xnew = np.full(elements, VOLFRAC), np.zeros(2 * nodes), np.empty(elements)
    compliances, seconds, change = [], [], 1.0
    while len(seconds) < iterations if iterations else change > 0.01:
        start = time.process_time()
        moduli = EMIN + x**PENAL * (E0 - EMIN)
        u[free] = solver.solve(assembly @ moduli, load)
        ue = u[dofs]
        ce = np.einsum("ij,ij->i", ue @ ke, ue)
        compliances.append(float(moduli @ ce))
        dc = -PENAL * (E0 - EMIN) * x ** (PENAL - 1) * ce
        dc = cone @ (x * dc) / cone_sum / np.maximum(1e-3, x)
        root, low, high = x * np.sqrt(-dc), np.maximum(0.0, x - MOVE), np.minimum(1.0, x + MOVE)
        l1, l2 = 0.0, 1e9
        while (l2 - l1) / (l1 + l2) > 1e-3:
            middle = 0.5 * (l1 + l2)
            np.multiply(root, middle**-0.5, out=xnew)
            np.clip(xnew, low, high, out=xnew)
            if xnew.sum() > VOLFRAC * elements:
                l1 = middle
            else:
                l2 = middle
        change = np.abs(xnew - x).max()
        x, xnew = xnew, x
        seconds.append(time.process_time() - start)
    return compliances, seconds


def pymoto(solver, iterations):
    """The same beam with pyMOTO's modules, its OC, and its density filter: it has no sensitivity filter."""
    os.environ["MPLBACKEND"] = "agg"
    warnings.simplefilter("ignore")
    import numpy as np
    import pymoto as pym

    domain = pym.VoxelDomain(NELX, NELY)
    supports = np.r_[2 * domain.nodes[0, :].ravel(), 2 * domain.nodes[NELX, 0].ravel() + 1]
    load = np.zeros(2 * domain.nnodes)
    load[2 * domain.nodes[0, NELY].ravel() + 1] = -1.0
    x = pym.Signal("x", state=np.full(domain.nel, VOLFRAC))
    with pym.Network() as network:
        filtered = pym.DensityFilter(domain, radius=RMIN)(x)
        moduli = pym.MathExpression(f"{EMIN} + {E0 - EMIN}*inp0^{PENAL:.0f}")(filtered)
        stiffness = pym.AssembleStiffness(domain, bc=supports, e_modulus=1.0, poisson_ratio=NU, plane="stress")(moduli)
        if solver is None:
            module = pym.LinSolve()
        else:
            chosen = getattr(pym.solvers, solver)()
            module = pym.LinSolve(symmetric=True, positive_definite=True, solver=chosen)
        u = module(stiffness, load)
        compliance = pym.EinSum("i,i->")(u, load)
    optimizer = pym.OC(x, compliance, network, move=MOVE, xmin=0.0, xmax=1.0, verbosity=0)
    compliances, seconds, values = [], [], x.state
    for _ in range(iterations):
        start = time.process_time()
        values, response, _ = optimizer.step(values)
        seconds.append(time.process_time() - start)
        compliances.append(float(np.ravel(response)[0]))
    used = module.solver
    return compliances, seconds, type(getattr(used, "solver", used)).__name__


PORTS = {
    "port, cvxopt CHOLMOD, nested dissection": (Cvxopt, True),
    "port, cvxopt CHOLMOD, AMD": (Cvxopt, False),
    "port, scikit-sparse CHOLMOD, nested dissection": (ScikitSparse, True),
    "port, scikit-sparse CHOLMOD, AMD": (ScikitSparse, False),
    "port, scipy splu, nested dissection": (SuperLU, True),
}
PYMOTO = {
    "pyMOTO, default": None,
    "pyMOTO, cvxopt CHOLMOD": "SolverSparseCholeskyCVXOPT",
    "pyMOTO, scikit-sparse CHOLMOD": "SolverSparseCholeskyScikit",
}


def measure(name):
    """One engine, one run: its row, without the time of the others."""
    if name == "check":
        return check()
    if name in PORTS:
        compliances, seconds = top88(*PORTS[name], NELX, NELY, RMIN, LAST)
        filtered = "sensitivity"
    else:
        compliances, seconds, solver = pymoto(PYMOTO[name], LAST)
        name, filtered = f"{name} ({solver})" if name == "pyMOTO, default" else name, "density"
    cpu = sum(seconds[WARM:LAST]) / (LAST - WARM)
    print(f"{name}\t{filtered}\t1\t{cpu:.4f}\t{compliances[0]:.4f}\t{compliances[-1]:.4f}")


def check():
    """The port against top88, in both orderings."""
    good = True
    for name in list(PORTS)[:2]:
        beam = top88(*PORTS[name], NELX, NELY, RMIN, 50)[0][-1]
        small = top88(*PORTS[name], 60, 20, 1.5)[0]
        good &= abs(beam - BEAM_50) < 1e-4 and abs(small[-1] - SMALL_END) < 1e-4 and len(small) == SMALL_ITERATIONS
        print(f"{name}: iteration 50 of {NELX} x {NELY} {beam:.4f} (top88 {BEAM_50}); ", end="")
        print(f"60 x 20 {small[-1]:.4f} after {len(small)} (top88 {SMALL_END} after {SMALL_ITERATIONS})", flush=True)
    return 0 if good else "the port is not top88"


def one_thread():
    """One thread, and OpenBLAS's best kernels also on processors its version does not know."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    environment = os.environ | dict.fromkeys(names, "1")
    try:
        flags = pathlib.Path("/proc/cpuinfo").read_text().split()
    except OSError:
        flags = []
    if "avx512f" in flags:
        environment["OPENBLAS_CORETYPE"] = "SKYLAKEX"
    elif "avx2" in flags:
        environment["OPENBLAS_CORETYPE"] = "HASWELL"
    return environment


def run_peers(python, repeats):
    """Prints the best row of each engine; returns the lowest CPU seconds."""
    environment = one_thread()

    def start(name, **more):
        return subprocess.run([python, __file__, "--measure", name], env=environment, text=True, **more)

    def imports(module):
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return subprocess.run([python, "-c", f"import {module}"], **quiet).returncode == 0

    start("check", check=True)
    kernels = environment.get("OPENBLAS_CORETYPE", "as it chooses")
    print(f"OpenBLAS kernels: {kernels}; best of {repeats}")
    print("engine\tfilter\tthreads\tcpu_s_per_iteration\tcompliance_1\tcompliance_30", flush=True)
    skipped = [] if imports("sksparse.cholmod") else ["scikit-sparse"]
    rows = {}
    for name in [*PORTS, *PYMOTO]:
        if any(word in name for word in skipped):
            print(f"{name}\tnot installed", flush=True)
            continue
        runs = [start(name, stdout=subprocess.PIPE) for _ in range(repeats)]
        lines = [line for run in runs if run.returncode == 0 for line in run.stdout.splitlines()]
        if not lines:
            print(f"{name}\tfailed", flush=True)
            continue
        best = min(lines, key=lambda line: float(line.split("\t")[3]))
        rows[name] = float(best.split("\t")[3])
        print(best, flush=True)
    return min(rows.items(), key=lambda row: row[1], default=None)


def run_ours(patterns):
    """Prints this project's lines; returns the CPU seconds of an iteration on one thread, if they are there."""
    command = [patterns] if patterns else ["cargo", "run", "--release", "--quiet", "--"]
    try:
        run = subprocess.run([*command, "bench", "topopt"], cwd=ROOT, text=True, capture_output=True)
    except OSError as error:
        print(f"this project\tfailed: {error}")
        return None
    lines = [line.strip() for line in run.stdout.splitlines() if "MBB" in line]
    for line in lines:
        print(f"this project\t{line}")
    if run.returncode != 0 or not lines:
        why = run.stderr.strip().splitlines() or ["no line begins with MBB"]
        print(f"this project\t`bench topopt` failed ({run.returncode}): {why[0]}")
    found = [(line, re.search(r"MBB 300x100.*?cpu ([0-9.]+)", line)) for line in lines]
    found = [(line, float(match[1])) for line, match in found if match]
    single = [cpu for line, cpu in found if re.search(r"\b1 thread\b|\bthreads:? 1\b", line)]
    return next(iter(single or [cpu for _, cpu in found]), None)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--venv", help="folder of the virtual environment, kept (default: temporary)")
    parser.add_argument("--scikit-sparse", action="store_true", help="builds it too (needs SuiteSparse's headers)")
    parser.add_argument("--repeats", type=int, default=2, help="runs of each peer, the best counts (default: 2)")
    parser.add_argument("--peers-only", action="store_true", help="leaves this project out")
    parser.add_argument("--patterns", type=pathlib.Path, help="this project's program, built (default: cargo run)")
    parser.add_argument("--measure", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        return measure(options.measure)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(options.venv or temporary).resolve()
        python = folder / "bin" / "python"
        if not python.exists():
            venv.create(folder, with_pip=True)
            requirements = HERE / "requirements.txt"
            subprocess.run([python, "-m", "pip", "install", "-q", "-r", requirements], check=True)
        if options.scikit_sparse:
            subprocess.run([python, "-m", "pip", "install", "-q", SCIKIT_SPARSE])
        peer = run_peers(python, options.repeats)
    if options.peers_only:
        return None
    ours = run_ours(options.patterns and options.patterns.resolve())
    if peer and ours:
        print(f"best peer / this project: {peer[1] / ours:.2f} ({peer[0]})")
    else:
        print("best peer / this project: not known")
    return None


if __name__ == "__main__":
    sys.exit(main())
