// Makes the tree of binary_tree.h on a GPU: the codes of the faces, the nodes (T. Karras, Maximizing parallelism in the
// construction of BVHs, octrees, and k-d trees, 2012), and what follows from the positions of the vertices, which is
// made again when they have moved.
//
// A node's box is joined from boxes of aligned ranges of places, so that no work-item waits for another one.

#include "binary_tree.h"
#include "group_sum.h"
#include "point_faces.h"
#include "point_tree.h"
#include "simd.h"
#include "spread_bits.h"

#pragma OPENCL FP_CONTRACT OFF

#define GROUP 64

// A corner of a face, in units.
static inline double3 corner(TreeLattice lattice, __global const double* positions, __global const uint* triangles,
                             uint face, uint number) {
    const double3 p = vload3(triangles[3 * (size_t)face + number], positions);
    return (double3)((p.x - lattice.origin[0]) / lattice.unit, (p.y - lattice.origin[1]) / lattice.unit,
                     (p.z - lattice.origin[2]) / lattice.unit);
}

// Codes. --------------------------------------------------------------------------------------------------------------

static inline uint cell_of(TreeLattice lattice, double sum) {
    const double cell = sum * lattice.cells_per_unit;
    const double positive = GREATER(cell, 0.0);
    return spread_bits((uint)(int)LESSER(positive, lattice.last_cell));
}

// The Morton code of each face, or of the face of each place if there is an order.
__kernel void codes_of_faces(uint count, TreeLattice lattice, __global const double* positions,
                             __global const uint* triangles, uint has_order, __global const uint* order,
                             __global uint* codes) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    const uint face = has_order ? order[i] : i;
    const double3 sum = corner(lattice, positions, triangles, face, 0) +
                        corner(lattice, positions, triangles, face, 1) + corner(lattice, positions, triangles, face, 2);
    codes[i] = cell_of(lattice, sum.x) | cell_of(lattice, sum.y) << 1 | cell_of(lattice, sum.z) << 2;
}

// Nodes. --------------------------------------------------------------------------------------------------------------

// How many bits from the highest one on are equal in the keys of two places; -1 if the second one does not exist.
static inline int equal_bits(__global const uint* codes, uint count, uint place, int other) {
    if (other < 0 || (uint)other >= count) return -1;
    const uint code = codes[place], of_other = codes[other];
    return code != of_other ? (int)clz(code ^ of_other) : 32 + (int)clz(place ^ (uint)other);
}

// Karras' node number i of count - 1, at whose one end the place i is.
static inline NodePlaces places_of_node(__global const uint* codes, uint count, uint i) {
    const int own = (int)i;
    const int step = equal_bits(codes, count, i, own + 1) > equal_bits(codes, count, i, own - 1) ? 1 : -1;
    const int beside = equal_bits(codes, count, i, own - step);
    int most = 2;
    while (equal_bits(codes, count, i, own + most * step) > beside) most *= 2;
    int length = 0;
    for (int t = most / 2; t > 0; t /= 2)
        if (equal_bits(codes, count, i, own + (length + t) * step) > beside) length += t;
    const int other = own + length * step, first = min(own, other), last = max(own, other);
    const int equal = equal_bits(codes, count, i, other);
    int middle = first;  // the last place of the first child
    for (int t = most; t > 0; t /= 2)
        if (middle + t < last && equal_bits(codes, count, (uint)first, middle + t) > equal) middle += t;
    NodePlaces places;
    places.first = (uint)first;
    places.middle = (uint)middle + 1u;
    places.end = (uint)last + 1u;
    return places;
}

static inline bool is_node(uint places) {
    return places > CLSDF_LEAF_PLACES;
}

// Whether Karras' nodes are nodes of the tree: 1 or 0.
__kernel void find_nodes(uint count, __global const uint* codes, __global uint* are_nodes) {
    const uint i = get_global_id(0);
    if (i + 1u >= count) return;
    const NodePlaces places = places_of_node(codes, count, i);
    are_nodes[i] = is_node(places.end - places.first);
}

static inline void mark_leaf(__global uint* order, uint first, uint end) {
    for (uint i = first; i < end; ++i) order[i] |= (end - 1u - i) << CLSDF_PLACE_SHIFT;
}

// starts: the prefix sums of are_nodes. leaf: see BinaryTree. parents: of each node; the root has none.
__kernel void link_nodes(uint count, uint leaf, __global const uint* codes, __global const uint* starts,
                         __global uint* order, __global NodePlaces* nodes, __global uint* parents) {
    const uint i = get_global_id(0);
    if (i + 1u >= count) return;
    NodePlaces node = places_of_node(codes, count, i);
    if (!is_node(node.end - node.first)) return;
    const uint number = starts[i];
    for (int child = 0; child < 2; ++child) {
        const uint begin = child == 0 ? node.first : node.middle, end = child == 0 ? node.middle : node.end;
        if (is_node(end - begin)) {
            node.link[child] = starts[child == 0 ? node.middle - 1u : node.middle];
            parents[node.link[child]] = number;
        } else {
            node.link[child] = leaf | begin;
            mark_leaf(order, begin, end);
        }
    }
    nodes[number] = node;
    if (i == 0) parents[0] = 0xFFFFFFFFu;
}

// A tree of one leaf.
__kernel void mark_only_leaf(uint count, __global uint* order) {
    if (get_global_id(0) == 0) mark_leaf(order, 0, count);
}

// The most nodes between the root and a leaf, both ends included.
__kernel void find_depth(uint count, __global const uint* parents, volatile __global uint* depth) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    uint levels = 1;
    for (uint node = parents[i]; node != 0xFFFFFFFFu; node = parents[node]) ++levels;
    atomic_max(depth, levels);
}

// Boxes. --------------------------------------------------------------------------------------------------------------

static inline FaceBox box_of_none(void) {
    FaceBox box;
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        box.lower[axis] = INFINITY;
        box.upper[axis] = -INFINITY;
    }
    return box;
}

static inline void join(FaceBox* box, __global const FaceBox* other) {
#pragma unroll
    for (int axis = 0; axis < 3; ++axis) {
        box->lower[axis] = LESSER(other->lower[axis], box->lower[axis]);
        box->upper[axis] = GREATER(other->upper[axis], box->upper[axis]);
    }
}

// The next float but one, or another near one: a rounded number is moved beyond what it was rounded from.
static inline float below(double x) {
    const float rounded = (float)x;
    return rounded - fabs(rounded) * 0x1.0p-23f;
}

static inline uint two_halves(double low, double high, double factor) {
    return ((uint)convert_int_rte(low * factor) & 0xFFFFu) | (uint)convert_int_rte(high * factor) << 16;
}

// Writes the quaternion of the rotation whose rows are x, y and their cross product z: the products of its numbers with
// the greatest one (S. W. Shepperd, Quaternion from rotation matrix, 1978).
static inline void store_turn(double3 x, double3 y, __global uint* turn) {
    const double3 z = cross(x, y);
    const double of_w = 1.0 + x.x + y.y + z.z, of_x = 1.0 + x.x - y.y - z.z, of_y = 1.0 - x.x + y.y - z.z,
                 of_z = 1.0 - x.x - y.y + z.z, most_xy = GREATER(of_x, of_y), most_zw = GREATER(of_z, of_w);
    double4 q;
    if (most_zw >= most_xy)
        q = of_w >= of_z ? (double4)(z.y - y.z, x.z - z.x, y.x - x.y, of_w)
                         : (double4)(x.z + z.x, y.z + z.y, of_z, y.x - x.y);
    else
        q = of_x >= of_y ? (double4)(of_x, x.y + y.x, x.z + z.x, z.y - y.z)
                         : (double4)(x.y + y.x, of_y, y.z + z.y, x.z - z.x);
    const double factor = CLSDF_GREATEST_OF_TURN / GREATER(most_xy, most_zw);
    turn[0] = two_halves(q.x, q.y, factor);
    turn[1] = two_halves(q.z, q.w, factor);
}

static inline void store_frame(__global const Polyhedron* polyhedron, __global const PointFace* face, bool is_followed,
                               __global PlacedFace* placed) {
    __global const double* axes[3] = {polyhedron->exact_gradient_x, polyhedron->exact_gradient_y,
                                      polyhedron->exact_gradient_z};
    for (int axis = 0; axis < 3; ++axis) {
        const double foot =
            -(axes[axis][0] * face->offset[0] + (axes[axis][1] * face->offset[1] + axes[axis][2] * face->offset[2]));
        placed->foot[axis] = convert_uint_sat_rte(foot * (double)CLSDF_FOOT_UNIT);
    }
    const float right = (float)polyhedron->exact_base[CLSDF_HALF_RIGHT];
    placed->right = as_float(as_uint(right) | (is_followed ? 0x80000000u : 0u));
    placed->left = (float)polyhedron->exact_base[CLSDF_HALF_LEFT];
    placed->altitude = (float)polyhedron->exact_altitude;
    store_turn((double3)(axes[0][0], axes[1][0], axes[2][0]), (double3)(axes[0][1], axes[1][1], axes[2][1]),
               placed->turn);
}

// The box and the frame of the face of each place.
__kernel void fit_faces(uint count, TreeLattice lattice, __global const double* positions,
                        __global const uint* triangles, __global const uint* order,
                        __global const Polyhedron* polyhedra, __global const PointFace* all_faces,
                        __global FaceBox* boxes, __global PlacedFace* faces) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    const uint face = order[i] & CLSDF_PLACE_FACE;
    const double3 a = corner(lattice, positions, triangles, face, 0),
                  b = corner(lattice, positions, triangles, face, 1),
                  c = corner(lattice, positions, triangles, face, 2);
    const double corners[3][3] = {{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}};
    FaceBox box;
    for (int axis = 0; axis < 3; ++axis) {
        const double first = corners[axis][0], second = corners[axis][1], third = corners[axis][2];
        const double lesser = LESSER(first, second), greater = GREATER(first, second);
        box.lower[axis] = below(LESSER(lesser, third));
        box.upper[axis] = -below(-GREATER(greater, third));
    }
    boxes[i] = box;
    store_frame(polyhedra + face, all_faces + face, order[i] >> CLSDF_PLACE_SHIFT != 0, faces + i);
}

// A level of boxes [from, from + count) becomes the next one, from + count on.
__kernel void join_boxes(uint count, uint from, __global FaceBox* boxes) {
    const uint first = (uint)get_global_id(0) * CLSDF_JOINED_BOXES;
    if (first >= count) return;
    FaceBox box = box_of_none();
    for (uint i = first; i < min(first + CLSDF_JOINED_BOXES, count); ++i) join(&box, boxes + from + i);
    boxes[from + count + (uint)get_global_id(0)] = box;
}

// The box of the places [begin, end). count: the places of the mesh.
static inline FaceBox box_of_places(__global const FaceBox* boxes, uint count, uint begin, uint end) {
    FaceBox box = box_of_none();
    while (begin < end) {
        for (; begin < end && begin % CLSDF_JOINED_BOXES != 0; ++begin) join(&box, boxes + begin);
        for (; begin < end && end % CLSDF_JOINED_BOXES != 0; --end) join(&box, boxes + end - 1u);
        begin /= CLSDF_JOINED_BOXES;
        end /= CLSDF_JOINED_BOXES;
        boxes += count;
        count = (count + CLSDF_JOINED_BOXES - 1u) / CLSDF_JOINED_BOXES;
    }
    return box;
}

// A word of a node: the planes of the lattice around a range of floats that are not negative. No quotient is rounded to
// a plane: a float that lies on none is at least 2^-30 units away, but from plane 0, where nothing is lost.
static inline uint planes_around(float lower, float upper) {
    return (uint)((double)lower / (double)CLSDF_BOX_CELL) | (uint)ceil((double)upper / (double)CLSDF_BOX_CELL) << 16;
}

static inline double area_of(FaceBox box) {
    const double x = (double)box.upper[0] - (double)box.lower[0], y = (double)box.upper[1] - (double)box.lower[1],
                 z = (double)box.upper[2] - (double)box.lower[2];
    return x * y + y * z + z * x;
}

DEFINE_SUM_BEFORE(area_before, double, GROUP)

// Writes the nodes, and half of the areas of their boxes, summed by groups. places: of the mesh.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void fit_nodes(uint places, uint count,
                                                                           __global const NodePlaces* of_nodes,
                                                                           __global const FaceBox* boxes,
                                                                           __global BinaryNode* nodes,
                                                                           __global double* areas) {
    __local double sums[GROUP];
    double area = 0.0;
    for (uint i = get_global_id(0); i < count; i += get_global_size(0)) {
        const uint middle = of_nodes[i].middle;
        for (int child = 0; child < 2; ++child) {
            const FaceBox box = box_of_places(boxes, places, child == 0 ? of_nodes[i].first : middle,
                                              child == 0 ? middle : of_nodes[i].end);
#pragma unroll
            for (int axis = 0; axis < 3; ++axis)
                nodes[i].box[child][axis] = planes_around(box.lower[axis], box.upper[axis]);
            nodes[i].link[child] = of_nodes[i].link[child];
            area += area_of(box);
        }
    }
    area_before(area, sums);
    if (get_local_id(0) == 0) areas[get_group_id(0)] = sums[GROUP - 1];
}

// One group.
__kernel __attribute__((reqd_work_group_size(GROUP, 1, 1))) void join_areas(uint count, __global const double* areas,
                                                                            __global PointFacesFound* found) {
    __local double sums[GROUP];
    double area = 0.0;
    for (uint i = get_local_id(0); i < count; i += GROUP) area += areas[i];
    area_before(area, sums);
    if (get_local_id(0) == 0) found->area = sums[GROUP - 1];
}
