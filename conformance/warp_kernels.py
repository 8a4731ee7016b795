"""The kernels of peers.py for Warp, which reads them from a file."""

import warp as wp


@wp.kernel
def winding_number(mesh: wp.uint64, points: wp.array(dtype=wp.vec3), found: wp.array(dtype=float)):
    i = wp.tid()
    query = wp.mesh_query_point_sign_winding_number(mesh, points[i], 1.0e30)
    found[i] = query.sign * wp.length(points[i] - wp.mesh_eval_position(mesh, query.face, query.u, query.v))


@wp.kernel
def parity(mesh: wp.uint64, points: wp.array(dtype=wp.vec3), found: wp.array(dtype=float)):
    i = wp.tid()
    query = wp.mesh_query_point_sign_parity(mesh, points[i], 1.0e30)
    found[i] = query.sign * wp.length(points[i] - wp.mesh_eval_position(mesh, query.face, query.u, query.v))


@wp.kernel
def normal(mesh: wp.uint64, points: wp.array(dtype=wp.vec3), found: wp.array(dtype=float)):
    i = wp.tid()
    query = wp.mesh_query_point_sign_normal(mesh, points[i], 1.0e30)
    found[i] = query.sign * wp.length(points[i] - wp.mesh_eval_position(mesh, query.face, query.u, query.v))
