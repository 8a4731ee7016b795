"""The drag of a body in a stream along x, by lbmpy: walls at their places on the links, and half-way along all of them.

pip install lbmpy    (it compiles its kernels when they are first used: g++ or clang++)
"""
import argparse

import lbmpy
import numpy as np
from lbmpy.boundaries import NoSlip, NoSlipLinearBouzidi

import clsdf

parser = argparse.ArgumentParser(description="Computes the drag of a body.")
parser.add_argument("mesh", help="a closed mesh: .stl, .off, .obj or .ply")
parser.add_argument("--reynolds", type=float, default=30, help="of the body's length, its longest side (30)")
parser.add_argument("--nodes", type=float, default=8, help="of the lattice along the body's length (8)")
parser.add_argument("--width", type=float, default=10, help="of the stream, in lengths; it repeats itself there (10)")
parser.add_argument("--travel", type=float, default=10, help="of the stream, in lengths (10)")
parser.add_argument("--shift", type=float, default=0.3, help="of the body's middle from a node, in voxels (0.3)")
options = parser.parse_args()

# A lattice around the body: 4 lengths of it before the middle, 6 behind.
body = clsdf.Transform(options.mesh)
lower, upper = np.array(body.box)
length = max(upper - lower)
voxel = length / options.nodes
along, across = round(10 * options.nodes), round(options.width * options.nodes)
middle = np.array((round(4 * options.nodes), across // 2, across // 2))
grid = clsdf.Grid((lower + upper) / 2 - voxel * (middle + options.shift), voxel, (along, across, across))
links = body.links(grid, ("D3Q19", "lbmpy"))
q = links.dense()


def set_parts(boundary_data, **_):
    """lbmpy has found each link from a node of the fluid into the body: clsdf has found the same ones."""
    found = boundary_data.index_array  # lbmpy counts nodes from its ghosts
    parts = q[found["dir"], found["z"] - 1, found["y"] - 1, found["x"] - 1]
    assert len(found) == len(links) and (parts >= 0).all()
    found["q"] = np.maximum(parts, 1e-9)  # lbmpy takes a q of 0, of a node on the wall, for none


def drag(wall):
    """The force along x over that of the pressure of the stream on a disc of the body's length."""
    speed = 0.08
    viscosity = speed * options.nodes / options.reynolds
    method = lbmpy.LBMConfig(
        stencil=lbmpy.LBStencil(lbmpy.Stencil.D3Q19), method=lbmpy.Method.TRT, compressible=True,
        relaxation_rate=lbmpy.relaxation_rate_from_lattice_viscosity(viscosity))
    flow = lbmpy.LatticeBoltzmannStep(domain_size=(along, across, across), periodicity=True, lbm_config=method)
    flow.boundary_handling.set_boundary(wall, mask_callback=lambda *_: np.pad(links.inside.T, 1))
    flow.data_handling.cpu_arrays[flow.velocity_data_name][...] = (speed, 0, 0)
    flow.set_pdf_fields_from_macroscopic_values()
    stream = flow.data_handling.cpu_arrays[flow.pdf_array_name][1].copy()
    for _ in range(round(options.travel * options.nodes / speed)):
        flow.time_step()
        populations = flow.data_handling.cpu_arrays[flow.pdf_array_name]
        populations[1] = populations[along] = stream  # what enters is the stream's, from both ends
    force = flow.boundary_handling.force_on_boundary(wall)
    return force[0] / (speed**2 / 2 * np.pi / 4 * options.nodes**2)


print(f"{along} x {across} x {across} nodes, {len(links)} links")
print(f"interpolated {drag(NoSlipLinearBouzidi('body', init_wall_distance=set_parts)):.4f}")
print(f"half-way     {drag(NoSlip('body')):.4f}")
