"""Runs CoACD and V-HACD on OBJ meshes, for `cargo run -p aam-lab --release --example decomposition`.

    pip install coacd vhacdx numpy
    python peers.py MESHES OUT

MESHES is a folder of OBJ files of triangles. Each program's hulls go to OUT/NAME.PROGRAM.obj, one object for each, and
the processor time of the call in seconds to OUT/NAME.PROGRAM.txt. What is there is not made again: CoACD takes
minutes a mesh. One process at a time, on one thread, so that times are of the program and not of the machine.
"""

import multiprocessing
import os
import pathlib
import resource
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"

import numpy  # noqa: E402

# As each program is meant to be used first, then coarser, for the charts.
PROGRAMS = [
    ("coacd-0.05", "coacd", {"threshold": 0.05}),
    ("vhacd-64", "vhacd", {"maxConvexHulls": 64}),
    ("vhacd-32", "vhacd", {"maxConvexHulls": 32}),
    ("vhacd-16", "vhacd", {"maxConvexHulls": 16}),
    ("coacd-0.1", "coacd", {"threshold": 0.1}),
    ("coacd-0.2", "coacd", {"threshold": 0.2}),
]


def read(path):
    vertices, triangles = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words and words[0] == "v":
            vertices.append([float(word) for word in words[1:4]])
        elif words and words[0] == "f":
            corners = [int(word.split("/")[0]) for word in words[1:]]
            corners = [corner - 1 if corner > 0 else len(vertices) + corner for corner in corners]
            triangles.extend([corners[0], corners[i], corners[i + 1]] for i in range(1, len(corners) - 1))
    return numpy.array(vertices, dtype=numpy.float64), numpy.array(triangles, dtype=numpy.int32)


def run(program, options, mesh, out):
    vertices, triangles = read(mesh)
    before = resource.getrusage(resource.RUSAGE_SELF)
    if program == "coacd":
        import coacd

        coacd.set_log_level("error")
        parts = coacd.run_coacd(coacd.Mesh(vertices, triangles), seed=0, **options)
    else:
        import vhacdx

        # The wrapper takes faces as a count and the corners' indices.
        faces = numpy.hstack([numpy.full((len(triangles), 1), 3), triangles]).astype(numpy.uint32).flatten()
        parts = vhacdx.compute_vhacd(vertices, faces, **options)
        parts = [(points, numpy.asarray(faces).reshape(-1, 4)[:, 1:] if numpy.asarray(faces).ndim == 1 else faces) for points, faces in parts]
    after = resource.getrusage(resource.RUSAGE_SELF)
    lines, base = [], 1
    for number, (points, faces) in enumerate(parts):
        lines.append(f"o hull_{number}")
        lines.extend("v %.9g %.9g %.9g" % tuple(point) for point in points)
        lines.extend("f %d %d %d" % tuple(int(corner) + base for corner in face) for face in faces)
        base += len(points)
    out.with_suffix(".txt").write_text(f"{after.ru_utime - before.ru_utime:.3f}\n")
    temporary = out.with_suffix(".part")
    temporary.write_text("\n".join(lines) + "\n")
    temporary.rename(out)


def main():
    meshes, out = map(pathlib.Path, sys.argv[1:3])
    out.mkdir(parents=True, exist_ok=True)
    for name, program, options in PROGRAMS:
        for mesh in sorted(meshes.glob("*.obj"), key=lambda path: (path.stat().st_size, path.name)):
            target = out / f"{mesh.stem}.{name}.obj"
            if target.exists():
                continue
            start = time.monotonic()
            # A process of its own: some meshes end the program.
            worker = multiprocessing.Process(target=run, args=(program, options, mesh, target))
            worker.start()
            worker.join()
            print(f"{target.name}: exit {worker.exitcode}, {time.monotonic() - start:.1f} s", flush=True)


if __name__ == "__main__":
    main()
