"""From a mesh to the flow past it: a stream along x, at a Reynolds number of 100, with peclet-flow.

pip install peclet-flow matplotlib
"""
import argparse

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import peclet.flow

import clsdf

parser = argparse.ArgumentParser(description="Computes and draws the flow past a body.")
parser.add_argument("mesh", help="a closed mesh: .stl, .off, .obj or .ply")
parser.add_argument("--picture", default="flow.png")
parser.add_argument("--cells", type=int, default=48, help="across the stream; twice as many along it (48)")
parser.add_argument("--lengths", type=float, default=8, help="of the body, which the stream travels (8)")
options = parser.parse_args()

# A box around the body, four lengths of it along x.
body = clsdf.Transform(options.mesh)
lower, upper = np.array(body.box)
length = max(upper - lower)
cells = (2 * options.cells, options.cells, options.cells)
extent = length * np.array((4, 2, 2))
origin = (lower + upper) / 2 - length * np.array((1.25, 1, 1))

solver = peclet.flow.Solver(cells, extent, origin)
step = 0.5 * solver.spacing[0]  # the stream has a speed of 1
solver.set_rho(1)
solver.set_mu(length / 100)
solver.set_dt(step)
solver.set_advection(True)
solver.set_domain_bc("-x", "inflow", (1, 0, 0))
solver.set_domain_bc("+x", "outflow")
for face in ("-y", "+y", "-z", "+z"):
    solver.set_domain_bc(face, "slip")

# The distance at the centres of the cells. The solver's arrays are [i, j, k] with x fastest: [k, j, i] of the same memory.
grid = clsdf.Grid(origin, solver.spacing, cells).cell_centred()
sdf = np.empty(cells, order="F")
body.field(grid, band="full", out=sdf.T)
solver.set_solid(sdf, cutcell_pressure=True)

for _ in range(round(options.lengths * length / step)):
    solver.step()

# The speed in the middle plane, seen along z, and the body before it. Velocities lie on the lower faces of cells.
middle = options.cells // 2
u, v, w = solver.get_u(), solver.get_v(), solver.get_w()
u = (u + np.append(u[1:], u[-1:], 0))[:, :, middle] / 2
v = (v + np.append(v[:, 1:], v[:, -1:], 1))[:, :, middle] / 2
w = (w[:, :, middle] + w[:, :, middle + 1]) / 2
x, y, _ = solver.cell_centers()
figure, axes = plt.subplots(figsize=(8, 4), dpi=100)
axes.set_position((0, 0, 1, 1))
axes.set_axis_off()
axes.imshow(np.sqrt(u**2 + v**2 + w**2).T, origin="lower", interpolation="bicubic", cmap="viridis", vmin=0, vmax=1.35,
            extent=(origin[0], origin[0] + extent[0], origin[1], origin[1] + extent[1]))
axes.streamplot(x, y, u.T, v.T, color=(1, 1, 1, 0.35), linewidth=0.6, arrowsize=0.6, density=1.2)

vertices, faces = clsdf.read_mesh(options.mesh)
corners = vertices[faces]
normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
order = np.argsort(corners[:, :, 2].mean(1))
corners, normals = corners[order], normals[order] / np.linalg.norm(normals[order], axis=1, keepdims=True)
light = 0.35 + 0.6 * np.clip(normals @ (-0.35, 0.45, 0.82), 0, 1)
axes.add_collection(matplotlib.collections.PolyCollection(
    corners[:, :, :2], facecolors=np.stack([light] * 3, 1), edgecolors="face", linewidths=0.2, zorder=3))
figure.savefig(options.picture)
