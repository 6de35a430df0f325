"""Times public packages on the problems written by `cargo bench --bench peers`; prints JSON.

In: problem files (vertices, triangles, dims, bbox, pins by vertex). Out: milliseconds per package, the fastest of several
runs on one thread, and the handles of the equivalent solve, so that the caller can compare results.
Packages: numpy, scipy, libigl; optionally bpy (Blender as a module).
"""

import json
import os
import sys
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import scipy.linalg
import scipy.sparse
from math import comb

ITERATIONS = 10


def fastest(run, seconds=1.0):
    """Milliseconds of the fastest run, and the result of the last one."""
    times, begin = [], time.perf_counter()
    while len(times) < 3 or time.perf_counter() - begin < seconds:
        start = time.perf_counter()
        result = run()
        times.append(1e3 * (time.perf_counter() - start))
    return min(times), result


def bernstein(count, t):
    i = np.arange(count)
    binomials = np.array([comb(count - 1, k) for k in i], dtype=float)
    return binomials * t[:, None] ** i * (1.0 - t[:, None]) ** (count - 1 - i)


def lp_ffd(problem):
    """The paper's solve: uniform edge weights, E_gr, ten local-global iterations, without any precomputation."""
    vertices, triangles = np.array(problem["vertices"]), np.array(problem["triangles"])
    low, high = np.array(problem["bbox"])
    unit = (vertices - low) / (high - low)
    nx, ny = problem["dims"]
    x, y = bernstein(nx, unit[:, 0]), bernstein(ny, unit[:, 1])
    weights = (y[:, :, None] * x[:, None, :]).reshape(len(vertices), nx * ny)
    grid_y, grid_x = np.meshgrid(np.linspace(0, 1, ny), np.linspace(0, 1, nx), indexing="ij")
    rest = low + np.stack([grid_x.ravel(), grid_y.ravel()], axis=1) * (high - low)
    edges = np.unique(np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1), axis=0)
    i, j = edges.T
    ones = np.ones(len(edges))
    adjacency = scipy.sparse.coo_matrix((np.r_[ones, ones], (np.r_[i, j], np.r_[j, i])), shape=(len(vertices),) * 2).tocsr()
    laplacian = scipy.sparse.diags(np.asarray(adjacency.sum(axis=1)).ravel()) - adjacency
    pinned = [pin["vertex"] for pin in problem["pins"]]
    targets = np.array([pin["target"] for pin in problem["pins"]])
    rows = weights[pinned]
    matrix = 2.0 * weights.T @ (laplacian @ weights) + 1e2 * rows.T @ rows + 1e-2 * np.eye(nx * ny)
    factor = scipy.linalg.lu_factor(matrix)
    constant = 1e2 * rows.T @ targets + 1e-2 * rest
    edge = vertices[i] - vertices[j]
    moved = vertices
    count = len(vertices)
    for _ in range(ITERATIONS):
        now = moved[i] - moved[j]
        along = np.einsum("ed,ed->e", edge, now)
        across = edge[:, 0] * now[:, 1] - edge[:, 1] * now[:, 0]
        cos = np.bincount(i, along, count) + np.bincount(j, along, count)
        sin = np.bincount(i, across, count) + np.bincount(j, across, count)
        length = np.hypot(cos, sin)
        length[length == 0.0] = 1.0
        turn = (cos + 1j * sin) / length
        turned = 0.5 * (turn[i] + turn[j]) * (edge[:, 0] + 1j * edge[:, 1])
        right = np.stack([
            np.bincount(i, part, count) - np.bincount(j, part, count) for part in (turned.real, turned.imag)
        ], axis=1)
        handles = scipy.linalg.lu_solve(factor, constant + 2.0 * weights.T @ right)
        moved = weights @ handles
    return handles


def arap(problem):
    """libigl's as-rigid-as-possible deformation of the mesh itself, without a lattice; ten iterations."""
    import igl

    vertices, triangles = np.array(problem["vertices"]), np.array(problem["triangles"], dtype=np.int64)
    pinned = np.array([pin["vertex"] for pin in problem["pins"]], dtype=np.int32)
    targets = np.array([pin["target"] for pin in problem["pins"]])

    def run():
        data = igl.ARAPData()
        data.max_iter = ITERATIONS
        igl.arap_precomputation(vertices, triangles, 2, pinned, data)
        return igl.arap_solve(targets, data, vertices.copy())

    return run


def blender_lattice(points):
    """Blender's lattice modifier (cubic B-spline, 15 x 15) on a mesh with this number of points."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    side = int(points**0.5)
    flat = np.stack(np.meshgrid(np.linspace(-0.49, 0.49, side), np.linspace(-0.49, 0.49, side)), axis=-1).reshape(-1, 2)
    mesh = bpy.data.meshes.new("points")
    mesh.vertices.add(len(flat))
    mesh.vertices.foreach_set("co", np.c_[flat, np.zeros(len(flat))].astype(np.float32).ravel())
    thing = bpy.data.objects.new("points", mesh)
    lattice = bpy.data.lattices.new("lattice")
    lattice.points_u, lattice.points_v, lattice.points_w = 15, 15, 1
    for axis in "uvw":
        setattr(lattice, f"interpolation_type_{axis}", "KEY_BSPLINE")
    cage = bpy.data.objects.new("lattice", lattice)
    for one in (thing, cage):
        bpy.context.collection.objects.link(one)
    modifier = thing.modifiers.new("lattice", "LATTICE")
    modifier.object = cage
    depsgraph = bpy.context.evaluated_depsgraph_get()

    def run():
        lattice.points[112].co_deform[0] += 0.001
        lattice.update_tag()
        thing.update_tag()
        depsgraph.update()
        return len(thing.evaluated_get(depsgraph).data.vertices)

    return run


def main():
    results = []
    for path in sys.argv[2:]:
        with open(path) as file:
            problem = json.load(file)
        milliseconds, handles = fastest(lambda: lp_ffd(problem))
        found = {"scipy_ms": milliseconds, "handles": handles.tolist()}
        try:
            found["libigl_ms"] = fastest(arap(problem))[0]
        except ImportError:
            pass
        results.append(found)
    answer = {"problems": results}
    try:
        answer["blender_ms"] = fastest(blender_lattice(int(sys.argv[1])))[0]
    except ImportError:
        pass
    # Blender prints to standard output, too, so the result is on the last line.
    print("\n" + json.dumps(answer))


main()
