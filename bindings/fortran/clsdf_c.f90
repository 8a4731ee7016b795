! Numbers, structs and functions of clsdf.h and clsdf_io.h, for the modules clsdf and clsdf_io, not for programs.
!
! Written by bindings/interface.py: change the headers, not this file.
module clsdf_c
  use, intrinsic :: iso_c_binding
  implicit none

  ! ---- Numbers ----

  integer(c_int32_t), parameter :: CLSDF_OK = 0
  !> index out of range, vertex in use not finite, no triangle, sign rule not met
  integer(c_int32_t), parameter :: CLSDF_INVALID_MESH = 1
  !> a file that cannot be opened, is truncated or malformed
  integer(c_int32_t), parameter :: CLSDF_UNREADABLE_INPUT = 2
  integer(c_int32_t), parameter :: CLSDF_INVALID_ARGUMENT = 3  !< an argument that makes no sense
  integer(c_int32_t), parameter :: CLSDF_NO_DEVICE = 4  !< no OpenCL device, or none of the name asked for
  integer(c_int32_t), parameter :: CLSDF_DEVICE_FAILURE = 5  !< an OpenCL call failed: clsdf_last_opencl_error()
  integer(c_int32_t), parameter :: CLSDF_OUT_OF_MEMORY = 6  !< of the host or the device
  !> a correct request that this build or device does not support
  integer(c_int32_t), parameter :: CLSDF_UNSUPPORTED = 7
  integer(c_int32_t), parameter :: CLSDF_CANCELLED = 8  !< for callbacks that cancel
  !> a result could not be written; nothing is left under its final name
  integer(c_int32_t), parameter :: CLSDF_OUTPUT_FAILURE = 9
  !> the device computes wrong values in the test at its first use
  integer(c_int32_t), parameter :: CLSDF_WRONG_RESULTS = 10
  !> a failure that the library does not expect; its message says which
  integer(c_int32_t), parameter :: CLSDF_UNEXPECTED = -1
  !> from here on: a program's own numbers, which clsdf never returns by itself
  integer(c_int32_t), parameter :: CLSDF_OWN_STATUS = 1000

  !> Types of the numbers in an array.
  integer(c_int32_t), parameter :: CLSDF_AUTOMATIC = 0  !< of an output: the type that clsdf_output_describe() states
  integer(c_int32_t), parameter :: CLSDF_FLOAT32 = 1
  integer(c_int32_t), parameter :: CLSDF_FLOAT64 = 2
  integer(c_int32_t), parameter :: CLSDF_INT32 = 3
  integer(c_int32_t), parameter :: CLSDF_INT64 = 4
  integer(c_int32_t), parameter :: CLSDF_UINT32 = 5
  integer(c_int32_t), parameter :: CLSDF_UINT64 = 6
  integer(c_int32_t), parameter :: CLSDF_UINT8 = 7

  !> Outputs. Beyond the band triangle and body are index_base - 1 (in uint32: 4294967295 or 0), the site 255, and
  !> vectors are NaN.
  integer(c_int32_t), parameter :: CLSDF_DISTANCE = 0  !< signed; always computed
  !> the nearest triangle; if an edge or a vertex is nearest, the lowest that shares it
  integer(c_int32_t), parameter :: CLSDF_TRIANGLE = 1
  !> 0 to 2: a vertex of it, 3 to 5: an edge, 6: its face; see CLSDF_SURFACE_OUTER
  integer(c_int32_t), parameter :: CLSDF_SITE = 2
  integer(c_int32_t), parameter :: CLSDF_CLOSEST = 3  !< the position of the closest point: float64
  integer(c_int32_t), parameter :: CLSDF_GRADIENT = 4  !< of the signed distance: a unit vector
  !> of the closest point: the weights of the triangle's vertices 1 and 2 (from 0)
  integer(c_int32_t), parameter :: CLSDF_BARYCENTRIC = 5
  integer(c_int32_t), parameter :: CLSDF_OFFSET = 7  !< from the sample or point to the closest point
  !> of a scene: the body of the nearest triangle; of a mesh index_base
  integer(c_int32_t), parameter :: CLSDF_BODY = 8

  !> Rules of the sign. balanced: nonzero; closed: parity; open: solid_angle if few points are in doubt; else none
  !> (call->log warns unless it is nonzero)
  integer(c_int32_t), parameter :: CLSDF_SIGN_AUTOMATIC = 0
  !> inside if the winding number is not zero; needs a balanced mesh
  integer(c_int32_t), parameter :: CLSDF_SIGN_NONZERO = 1
  !> inside if a ray crosses the surface an odd number of times; needs a closed mesh
  integer(c_int32_t), parameter :: CLSDF_SIGN_PARITY = 2
  integer(c_int32_t), parameter :: CLSDF_SIGN_NONE = 3  !< the distance alone
  !> inside if the winding number is one half or more, or -1/2 or less; any mesh
  integer(c_int32_t), parameter :: CLSDF_SIGN_SOLID_ANGLE = 4
  !> inside below a terrain and above clsdf_transform_options.floor, between walls from its rim
  integer(c_int32_t), parameter :: CLSDF_SIGN_BELOW = 5

  !> The surface that distances are measured to.
  integer(c_int32_t), parameter :: CLSDF_SURFACE_GIVEN = 0  !< all faces as given, also within other parts

  !> The outer surface of overlapping parts, as clsdf_mesh_outer() makes it. Triangles are told by the faces as given
  !> that they are parts of; a site beside those of a triangle, 7, is an edge or a vertex at which faces cut each other.
  integer(c_int32_t), parameter :: CLSDF_SURFACE_OUTER = 1

  !> The hits that count where a segment or a ray meets the surface.
  !> where inside and outside meet, by the sign rule: never a face within the body
  integer(c_int32_t), parameter :: CLSDF_WALLS = 0
  !> every face as given, also of sheets and of meshes without a sign
  integer(c_int32_t), parameter :: CLSDF_FACES = 1

  !> The place of a box.
  integer(c_int32_t), parameter :: CLSDF_WITHIN = 0  !< the surface may be within the half width of a point of the box
  !> the surface is farther from every point of the box, and all are inside
  integer(c_int32_t), parameter :: CLSDF_INSIDE = 1
  integer(c_int32_t), parameter :: CLSDF_OUTSIDE = 2  !< the same, and all are outside
  integer(c_int32_t), parameter :: CLSDF_BEYOND = 3  !< the same, of a mesh without a sign

  !> The outcome of a point in a plan's run.
  integer(c_int32_t), parameter :: CLSDF_FOUND = 0
  integer(c_int32_t), parameter :: CLSDF_NOT_FINITE = 1  !< the distance is NaN; there is no triangle
  !> the distance is the half width, or NaN if that is infinite; there is no triangle
  integer(c_int32_t), parameter :: CLSDF_TOO_FAR = 2
  !> exact arithmetic did not suffice: NaN, no triangle; clsdf_query() has the sign
  integer(c_int32_t), parameter :: CLSDF_SIGN_OPEN = 3
  integer(c_int32_t), parameter :: CLSDF_GPU = 0
  integer(c_int32_t), parameter :: CLSDF_PROCESSOR = 1
  integer(c_int32_t), parameter :: CLSDF_ACCELERATOR = 2
  integer(c_int32_t), parameter :: CLSDF_OTHER_DEVICE = 3

  !> How a device was found.
  integer(c_int32_t), parameter :: CLSDF_REGISTERED = 0  !< OpenCL's loader lists it
  integer(c_int32_t), parameter :: CLSDF_BUNDLED = 1  !< of the driver that the package with this library contains
  !> of a GPU's driver in the path of the system's loader, which OpenCL's does not know
  integer(c_int32_t), parameter :: CLSDF_UNREGISTERED = 2
  integer(c_int32_t), parameter :: CLSDF_DEVICE_FILE = 3  !< a GPU's file in /dev, and no device that can be used

  !> Units of a length.
  integer(c_int32_t), parameter :: CLSDF_MESH_UNITS = 0
  integer(c_int32_t), parameter :: CLSDF_VOXELS = 1
  integer(c_int32_t), parameter :: CLSDF_EXTENT = 2  !< the longest side of the mesh's box: 0.1 is 10% of it

  !> Stages of a call.
  integer(c_int32_t), parameter :: CLSDF_COMPILING = 0
  integer(c_int32_t), parameter :: CLSDF_COMPUTING = 1
  integer(c_int32_t), parameter :: CLSDF_TESTING = 2  !< programs compute a known field

  !> Bricks are blocks of 8 x 8 x 8 samples. They tile the lattice from its sample (0, 0, 0); a brick is named by its
  !> first sample.
  integer(c_int32_t), parameter :: CLSDF_BRICK_SIDE = 8
  integer(c_int32_t), parameter :: CLSDF_BRICK_SAMPLES = 512

  !> Bits that tell of a link.
  !> the sign changes where an open mesh has no face: no triangle, q to 2^-30
  integer(c_int32_t), parameter :: CLSDF_LINK_FILM = 1
  integer(c_int32_t), parameter :: CLSDF_LINK_BETWEEN = 2  !< both ends are outside, with a body between them
  integer(c_int32_t), parameter :: CLSDF_LINK_SHEET = 8  !< of CLSDF_FACES: both ends are on one side
  !> the wall is one of the walls or the floor of CLSDF_SIGN_BELOW: no triangle
  integer(c_int32_t), parameter :: CLSDF_LINK_CLOSING = 16

  !> The part of a cell that is measured.
  integer(c_int32_t), parameter :: CLSDF_PART_SOLID = 0
  integer(c_int32_t), parameter :: CLSDF_PART_FLUID = 1

  !> The cell that has a piece of surface in the face between two cells: the one above, or the one on that side.
  integer(c_int32_t), parameter :: CLSDF_WALL_ABOVE = 0
  integer(c_int32_t), parameter :: CLSDF_WALL_SOLID = 1
  integer(c_int32_t), parameter :: CLSDF_WALL_FLUID = 2

  !> Values of the array `types`: a cell without the part, wholly of it, met by the surface.
  integer(c_int32_t), parameter :: CLSDF_CELL_EMPTY = 0
  integer(c_int32_t), parameter :: CLSDF_CELL_FULL = 1
  integer(c_int32_t), parameter :: CLSDF_CELL_CUT = 2

  !> The use of an array in a call.
  integer(c_int32_t), parameter :: CLSDF_CUDA_READ = 0
  integer(c_int32_t), parameter :: CLSDF_CUDA_WRITE = 1  !< every byte gets a new value
  !> some bytes keep their value, as those between the values of an array with strides
  integer(c_int32_t), parameter :: CLSDF_CUDA_UPDATE = 2

  ! ---- Structs of C ----

  !> Numbers in the caller's memory. An array has items: vertices, triangles, points or samples, each of one number or
  !> of several components. It lies on the host or in a buffer of the device. The caller may free or reuse it when the
  !> call returns; only a plan writes later, to its targets, until its last run has ended. Strides of an output cost a
  !> copy of its samples inside the call. An input is not written, though `host` is not const.
  type, bind(C) :: c_array
    type(c_ptr) :: host = c_null_ptr  !< the address of the first item, or null
    type(c_ptr) :: device = c_null_ptr  !< a cl_mem, or null
    integer(c_int64_t) :: offset = 0  !< bytes before the first item, a multiple of a number's bytes
    !> of items; 0 if that of an output is not known. Any other count must be exactly that of the grid's samples, of the
    !> points, or of the samples of all blocks, with strides, too
    integer(c_int64_t) :: count = 0
    !> bytes from an item to the next along x, y, z; inputs and points: strides[0] alone. Negative ones run backwards
    !> from the first item. Zeros: packed, x fastest
    integer(c_int64_t) :: strides(3) = 0
    !> bytes from a component to the next; 0: side by side. If it is set and `strides` are not: the first components of
    !> all items, then the second ones
    integer(c_int64_t) :: component_stride = 0
    !> bytes from a block of a clsdf_block_set to the next; 0: the blocks follow each other
    integer(c_int64_t) :: block_stride = 0
    !> of host memory from `host` on; 0: unknown. An array that reaches beyond is refused
    integer(c_int64_t) :: bytes = 0
    integer(c_int32_t) :: type = 0  !< CLSDF_FLOAT32 ...
    !> 1: `host` is pinned: mapped memory of a buffer with CL_MEM_ALLOC_HOST_PTR, or page-locked by another interface of
    !> the device's driver. A packed field is then read into it without a copy by the host. Inputs: not used
    integer(c_int32_t) :: pinned = 0
  end type

  !> An output and the array that it is written to. The triangle may be uint32 or int32; distance, gradient, barycentric
  !> and offset may be float32 or float64; the site is uint8; the closest point, a position, is float64. As float64 they
  !> are evaluated in double, so that rounding them does not give the float32 results to the last bit.
  type, bind(C) :: c_target
    integer(c_int32_t) :: output = 0  !< CLSDF_DISTANCE ...
    integer(c_int32_t) :: reserved = 0
    type(c_array) :: array  !< one without memory is not wanted
  end type

  !> The targets of one request, one for each output at most; the distance has one.
  type, bind(C) :: c_targets
    type(c_ptr) :: items = c_null_ptr
    integer(c_int64_t) :: count = 0
  end type

  !> A row of the table of outputs.
  type, bind(C) :: c_output_info
    integer(c_size_t) :: struct_size = 41
    integer(c_int32_t) :: output = 0
    integer(c_int32_t) :: type = 0  !< of a value, in fields and files
    integer(c_int64_t) :: components = 0  !< values of a sample, which lie side by side
    type(c_ptr) :: name = c_null_ptr  !< "distance"; lives as long as the process, as the next
    type(c_ptr) :: description = c_null_ptr  !< in words
  end type

  type, bind(C) :: clsdf_box
    real(c_double) :: lower(3) = 0
    real(c_double) :: upper(3) = 0  !< included
  end type

  type, bind(C) :: clsdf_length
    real(c_double) :: value = 0
    integer(c_int32_t) :: unit = 0  !< CLSDF_MESH_UNITS ...
    integer(c_int32_t) :: reserved = 0
  end type

  !> Samples with -inside <= distance <= outside carry their distance, others +outside or -inside. Both may be infinite;
  !> at least one is > 0. With signs_only both are 0, and the field holds -0.0 inside and +0.0 outside. With exact_signs
  !> the field is below 0 at exactly those samples that are inside by the exact sides of links and crossings, on the
  !> surface, too: values inside are then at most minus the least normal float.
  type, bind(C) :: clsdf_band
    real(c_double) :: inside = 0
    real(c_double) :: outside = 0
    integer(c_int32_t) :: signs_only = 0  !< 0 or 1
    integer(c_int32_t) :: exact_signs = 0  !< 0 or 1
  end type

  !> Sample (i, j, k) lies at origin + (i hx, j hy, k hz). The grid is the block first <= (i, j, k) < first + size of
  !> this lattice; x runs fastest in memory. Results do not depend on `first`: a part has the bytes of the whole.
  type, bind(C) :: c_grid
    real(c_double) :: origin(3) = 0
    real(c_double) :: spacing(3) = 1
    integer(c_int64_t) :: size(3) = 0
    integer(c_int64_t) :: first(3) = 0
  end type

  !> Options of clsdf_grid_around_box().
  type, bind(C) :: c_grid_options
    integer(c_size_t) :: struct_size = 64
    integer(c_int64_t) :: resolution = 256  !< samples on the longest side of the box, margin included; >= 2
    real(c_double) :: spacing(3) = 0  !< per axis, instead of a resolution; zeros: not set
    !> 0: the first sample on the longest side is box->lower exactly
    type(clsdf_length) :: margin = clsdf_length(0.05_c_double, 2, 0)
    integer(c_int32_t) :: cubic = 0  !< 1: every axis gets as many samples as the longest one
    integer(c_int32_t) :: cell_centred = 0  !< 1: samples at the centres of cells, half a voxel further
  end type

  !> How clsdf_grid_between() divides a box: by samples or by cells. Give one of them, on each axis; the other is 0.
  type, bind(C) :: c_grid_division
    integer(c_size_t) :: struct_size = 64
    !> at least 2: both ends of the box are samples; 1 on an axis on which they are equal
    integer(c_int64_t) :: samples(3) = 0
    integer(c_int64_t) :: cells(3) = 0  !< at least 1: samples at their corners, one more than the cells
    integer(c_int32_t) :: cell_centred = 0  !< 1, with cells: one sample at the centre of each instead
    integer(c_int32_t) :: reserved = 0
  end type

  !> The properties that a device reports; unknown ones are 0 or "". Texts live as long as the handle that gave them.
  type, bind(C) :: c_device_info
    integer(c_size_t) :: struct_size = 137
    integer(c_int64_t) :: index = 0  !< in the list of devices; -1: not in it, as a part of a device
    type(c_ptr) :: id = c_null_ptr  !< cl_device_id
    type(c_ptr) :: name = c_null_ptr  !< of a device without one, that of its platform
    type(c_ptr) :: platform = c_null_ptr
    type(c_ptr) :: version = c_null_ptr  !< of OpenCL
    type(c_ptr) :: driver = c_null_ptr  !< its version
    type(c_ptr) :: why_not = c_null_ptr  !< why this library cannot use it; "" if it can
    integer(c_int64_t) :: compute_units = 0  !< 0: this and all to atomics64 are unknown
    integer(c_int64_t) :: clock_megahertz = 0
    integer(c_int64_t) :: memory = 0  !< bytes
    integer(c_int64_t) :: largest_allocation = 0  !< bytes
    integer(c_int64_t) :: float_width = 0  !< floats in a native vector; 1 on most GPUs
    integer(c_int32_t) :: kind = 0  !< CLSDF_GPU ...
    integer(c_int32_t) :: fp64 = 0  !< 1: double precision, which this library needs
    integer(c_int32_t) :: atomics64 = 0  !< 1: atomic operations on 64 bits, which it does not need
    integer(c_int32_t) :: source = 0  !< CLSDF_REGISTERED ..., how it was found: always known
    !> if this library opened it; of CLSDF_DEVICE_FILE, the file in /dev; else ""
    type(c_ptr) :: driver_file = c_null_ptr
    type(c_ptr) :: only_if_named = c_null_ptr  !< why it is taken only if it is named, though it can be used; else ""
  end type

  !> Limits of clsdf_device_limited().
  type, bind(C) :: c_device_limits
    integer(c_size_t) :: struct_size = 24
    integer(c_int64_t) :: compute_units = 0  !< to use; on a processor, cores. 0: all
    integer(c_int64_t) :: memory = 0  !< bytes that the buffers of one transform and its plans may take; 0: all
  end type

  type, bind(C) :: clsdf_progress
    integer(c_int32_t) :: stage = 0  !< CLSDF_COMPILING, CLSDF_COMPUTING, CLSDF_TESTING
    integer(c_int32_t) :: reserved = 0
    real(c_double) :: fraction = 0  !< of the stage, 0 to 1
    integer(c_int64_t) :: step = 0  !< of compiling, from 1
    integer(c_int64_t) :: steps = 0  !< of compiling, at most
  end type

  !> Options of one call. Functions may be null.
  type, bind(C) :: c_call_options
    integer(c_size_t) :: struct_size = 64
    type(c_ptr) :: user = c_null_ptr  !< the first argument of the functions
    type(c_funptr) :: progress = c_null_funptr  !< called between launches, and before each step of building programs
    type(c_funptr) :: should_stop = c_null_funptr  !< asked there, too
    type(c_funptr) :: log = c_null_funptr  !< warnings of this call
    type(c_ptr) :: wait_list = c_null_ptr  !< cl_events after which the call uses the caller's memory
    integer(c_int64_t) :: wait_count = 0
    !> 1: clsdf_query() fails if a point is not finite or too far from the mesh
    integer(c_int32_t) :: refuse_unusable_points = 0
    integer(c_int32_t) :: reserved = 0
  end type

  !> Times (wall-clock seconds of the host) and memory of a call.
  type, bind(C) :: clsdf_statistics
    integer(c_size_t) :: struct_size = 73
    integer(c_int64_t) :: slabs = 0  !< parts of the grid computed one after the other
    integer(c_int64_t) :: device_bytes = 0  !< the most that buffers took at once; of a plan, its own buffers
    integer(c_int64_t) :: host_bytes = 0  !< the library's arrays on the host for slabs
    real(c_double) :: compile_seconds = 0  !< building or loading the device's programs, and testing them
    real(c_double) :: polyhedra_seconds = 0  !< preparing the mesh
    real(c_double) :: field_seconds = 0  !< samples or points
    integer(c_int32_t) :: first_use = 0  !< 1: programs computed for the first time on this device
    integer(c_int32_t) :: reserved = 0
    !> of clsdf_query(): points that are not finite or too far from the mesh
    integer(c_int64_t) :: unusable_points = 0
  end type

  !> A mesh in the caller's arrays, on the host or in buffers of the device's context. Each call that takes one copies
  !> what it keeps.
  type, bind(C) :: c_mesh_arrays
    integer(c_size_t) :: struct_size = 200
    type(c_array) :: vertices  !< three float32 or float64 an item
    !> three indices an item, int32, int64, uint32 or uint64, counter-clockwise from outside
    type(c_array) :: triangles
    !> 0 or 1: what indices of vertices count from, and triangles of outputs. With 1, `triangles` lie on the host, and a
    !> copy of them is made for the call
    integer(c_int32_t) :: index_base = 1
    integer(c_int32_t) :: reserved = 0
    !> of the mesh that clsdf_mesh_create() makes, in messages and files; null: "mesh"
    type(c_ptr) :: name = c_null_ptr
  end type

  type, bind(C) :: clsdf_edge
    real(c_double) :: from(3) = 0
    real(c_double) :: to(3) = 0
  end type

  !> The facts that decide the sign rule. Vertices of equal coordinates count as one. If the mesh itself is not
  !> balanced, another surface decides the sign, with joined vertices, doubled faces that count once and faces turned
  !> around: what is said of closed and balanced meshes and of edges is true of that surface.
  type, bind(C) :: c_topology
    integer(c_size_t) :: struct_size = 849
    integer(c_int32_t) :: closed = 0  !< 1: every undirected edge has an even number of faces
    integer(c_int32_t) :: balanced = 0  !< 1: every edge is used equally often in both directions
    !> 1: balanced, and the enclosed volume is negative; or not, and the winding number is
    integer(c_int32_t) :: inside_out = 0
    integer(c_int32_t) :: reserved = 0
    integer(c_int64_t) :: open_edges = 0  !< undirected edges with an odd number of faces
    integer(c_int64_t) :: unbalanced_edges = 0  !< undirected edges not used equally often in both directions
    integer(c_int64_t) :: non_manifold_edges = 0  !< undirected edges with more than two faces, of the mesh itself
    integer(c_int64_t) :: repeated_vertex_faces = 0  !< faces with fewer than three different vertices
    integer(c_int64_t) :: coincident_vertices = 0  !< vertices in use that equal an earlier one
    integer(c_int64_t) :: unused_vertices = 0
    integer(c_int64_t) :: first_open_count = 0  !< of first_open
    integer(c_int64_t) :: first_unbalanced_count = 0  !< of first_unbalanced
    type(clsdf_edge) :: first_open(5)  !< in the order of the triangles
    type(clsdf_edge) :: first_unbalanced(5)
    integer(c_int64_t) :: boundary_edges = 0  !< undirected edges with one face: some of the open ones
    integer(c_int64_t) :: joined_vertices = 0  !< in use, differ from another one by rounding and count as it
    integer(c_int64_t) :: duplicate_faces = 0  !< with the vertices of an earlier face; 0 if every edge has two faces
    integer(c_int64_t) :: uncounted_faces = 0  !< of doubled faces those that do not count for the sign
    integer(c_int64_t) :: reoriented_faces = 0  !< look the wrong way and are turned around for the sign
    integer(c_int64_t) :: inner_wall_faces = 0  !< between regions; without them the mesh would be closed
    integer(c_int64_t) :: first_inner_wall_face = 0  !< the lowest of them, counted from 0, as those that follow
    integer(c_int64_t) :: parts = 0  !< of a balanced mesh: those that share no vertex; else 0
    integer(c_int64_t) :: inward_parts = 0  !< look inwards and are not wholly within others
    integer(c_int64_t) :: first_inward_face = 0  !< the lowest face of the first of them
    integer(c_int64_t) :: nested_parts = 0  !< lie within others, look the same way and are filled
    integer(c_int64_t) :: first_nested_face = 0  !< the lowest face of the first of them
    !> These three are 0 unless the mesh is not balanced and the rule may become solid_angle.
    !> points beside faces and in the parts' boxes at which the winding number was computed
    integer(c_int64_t) :: tested_points = 0
    integer(c_int64_t) :: doubtful_points = 0  !< tested points at which it is more than 0.1 from an integer
    integer(c_int64_t) :: inside_points = 0  !< tested points at which it is at least 1/2, or at most -1/2
    !> parts where it is in doubt at more than a tenth of them, or at none inside
    integer(c_int64_t) :: unclear_parts = 0
    integer(c_int64_t) :: first_unclear_face = 0  !< the lowest face of the first of them
    integer(c_int64_t) :: double_sided_faces = 0  !< of bodies that are there on both sides; each counts once
    integer(c_int64_t) :: doubled_cavity_faces = 0  !< of cavities that are there twice, so the cavities are filled
    integer(c_int64_t) :: first_doubled_cavity_face = 0  !< the lowest of them
    integer(c_int64_t) :: sheet_faces = 0  !< of sheets and inner walls beside closed bodies, left out for the sign
    integer(c_int64_t) :: first_sheet_face = 0  !< the lowest of them
    integer(c_int64_t) :: enclosing_faces = 0  !< of open sheets that are not left out, because they enclose something
    integer(c_int64_t) :: first_enclosing_face = 0  !< the lowest of them
    integer(c_int64_t) :: overlapping_parts = 0  !< parts of a balanced mesh that are partly within others
    integer(c_int64_t) :: first_overlapping_face = 0  !< the lowest face of the first of them
    !> The rule below needs a mesh that is not closed, whose faces look up and whose rim does not overlap.
    integer(c_int64_t) :: downward_faces = 0  !< look down, to smaller z
    integer(c_int64_t) :: first_downward_face = 0  !< the lowest of them
    !> of a mesh that is not closed and has no downward_faces: loops of open edges
    integer(c_int64_t) :: rim_loops = 0
    !> of them that cross others, seen from above, or at which the mesh lies twice
    integer(c_int64_t) :: overlapping_rim_edges = 0
    !> Small open parts that are attached to the others and count as details of them; 0 if the mesh has its sign without
    !> that.
    integer(c_int64_t) :: detail_parts = 0
    integer(c_int64_t) :: detail_faces = 0  !< of these parts
    integer(c_int64_t) :: first_detail_face = 0  !< the lowest of them
    !> Set for a transform with CLSDF_SURFACE_OUTER; else 0.
    integer(c_int64_t) :: partial_faces = 0  !< faces of which parts are on the outer surface
    integer(c_int64_t) :: hidden_faces = 0  !< faces that are not on it at all
  end type

  !> Defects beside those of edges. The distance is exact in spite of them.
  type, bind(C) :: clsdf_defects
    integer(c_size_t) :: struct_size = 33
    integer(c_int64_t) :: zero_area_faces = 0  !< three different vertices on one line, exactly
    integer(c_int64_t) :: duplicate_faces = 0  !< with the vertices of an earlier face, in whatever order
    integer(c_int64_t) :: components = 0  !< parts that share no vertex
  end type

  !> How files of meshes are read.
  type, bind(C) :: c_read_options
    integer(c_size_t) :: struct_size = 104
    type(c_ptr) :: user = c_null_ptr  !< the first argument of the function
    !> Warnings, each with the file: what was skipped (faces of one or two corners, bytes after the last row of a binary
    !> .ply, unknown lines) or changed (vertices of an .obj with a fourth number are divided by it). May be null.
    type(c_funptr) :: log = c_null_funptr
    !> a position x becomes R (x * scale) + translate; without a rotation R, product and sum are each rounded once; > 0
    real(c_double) :: scale = 1
    real(c_double) :: translate(3) = 0  !< in the units after the scale
    !> 1: faces with a coordinate that is not finite, or that name a vertex that does not exist, are left out; log gets
    !> their number and the first of them. 0: they are errors.
    integer(c_int32_t) :: skip_bad_facets = 0
    integer(c_int32_t) :: reserved = 0
    !> the axis of the file that points up: "x", "y", "z", "-x", "-y" or "-z"; null: "z". The mesh gets z up: of a file
    !> with y up, (x, y, z) becomes (x, -z, y)
    type(c_ptr) :: up = c_null_ptr
    !> degrees about the fixed axes x, y and z, one after the other, after `up`; exact for multiples of 90
    real(c_double) :: rotate(3) = 0
    !> a property of the faces of .ply files, whose values name the groups; null: none
    type(c_ptr) :: group_by = c_null_ptr
  end type

  !> How a mesh differs from the one that it was welded from, face by face.
  type, bind(C) :: clsdf_weld_report
    integer(c_size_t) :: struct_size = 41
    integer(c_int64_t) :: lost_faces = 0  !< had three different vertices, and have fewer now, so no area
    integer(c_int64_t) :: coinciding_faces = 0  !< have the three vertices of other faces now, and did not before
    !> A closed mesh has its volume, > 0 if its faces look outwards; an open one that of the cones from the faces to the
    !> centre of the box.
    real(c_double) :: volume_before = 0
    real(c_double) :: volume_after = 0
  end type

  !> An outer surface, beside the faces as given.
  type, bind(C) :: clsdf_outer_report
    integer(c_size_t) :: struct_size = 49
    integer(c_int64_t) :: whole_faces = 0  !< faces as given that are on the outer surface wholly,
    integer(c_int64_t) :: partial_faces = 0  !< in parts,
    integer(c_int64_t) :: hidden_faces = 0  !< and not at all
    real(c_double) :: volume = 0  !< inside, in cubed units of the mesh
    real(c_double) :: area = 0  !< of the outer surface, in squared units
  end type

  type, bind(C) :: c_transform_options
    integer(c_size_t) :: struct_size = 32
    integer(c_int32_t) :: sign = 0  !< CLSDF_SIGN_AUTOMATIC ...
    integer(c_int32_t) :: surface = 0  !< CLSDF_SURFACE_GIVEN, the default, or CLSDF_SURFACE_OUTER
    integer(c_int64_t) :: kept_bytes = -1  !< limit of the device memory kept between calls; 0: none; -1: the default
    !> of CLSDF_SIGN_BELOW, which needs one: z below all vertices; DBL_MAX, the default: none
    real(c_double) :: floor = 1.7976931348623157e308_c_double
  end type

  !> Memory that a transform keeps between calls, beside the mesh.
  type, bind(C) :: clsdf_kept_memory
    integer(c_size_t) :: struct_size = 41
    integer(c_int64_t) :: host_bytes = 0
    integer(c_int64_t) :: device_bytes = 0
    !> All transforms of the device share these: clsdf_device_release_memory() gives them back.
    integer(c_int64_t) :: shared_host_bytes = 0  !< for copies, most of it pinned
    integer(c_int64_t) :: shared_device_bytes = 0  !< that no transform uses
  end type

  !> A box of the domain, and what is asked in it.
  type, bind(C) :: clsdf_region
    type(clsdf_box) :: box
    real(c_double) :: half_width = 0  !< the largest distance asked for; positive and finite
    real(c_double) :: spacing = 0  !< the largest spacing of grids; 0: only points and boxes
  end type

  !> One box of many.
  type, bind(C) :: c_request
    type(c_grid) :: grid
    type(clsdf_band) :: band
    type(c_targets) :: targets
  end type

  !> Equal blocks of one lattice.
  type, bind(C) :: c_block_set
    integer(c_size_t) :: struct_size = 184
    type(c_grid) :: lattice  !< its origin and spacing count
    type(clsdf_band) :: band
    integer(c_int64_t) :: size(3) = 0  !< samples of each block
    type(c_ptr) :: first = c_null_ptr  !< [block_count][3]: the first sample of each block, on the lattice
    integer(c_int64_t) :: block_count = 0
    type(c_targets) :: targets  !< of the first block; clsdf_array.block_stride leads to the others
  end type

  type, bind(C) :: c_slab_options
    integer(c_size_t) :: struct_size = 16
    !> 1: the function is called on another thread, while the next slab is computed
    integer(c_int32_t) :: own_thread = 0
    integer(c_int32_t) :: reserved = 0
  end type

  !> Bricks that follow each other along x: (first[0] + 8 n, first[1], first[2]) for n < count.
  type, bind(C) :: c_brick_run
    integer(c_int64_t) :: first(3) = 0
    integer(c_int64_t) :: count = 0
  end type

  !> How many bricks with values a sparse field has, and how many runs of bricks inside.
  type, bind(C) :: clsdf_sparse_counts
    integer(c_int64_t) :: bricks = 0
    integer(c_int64_t) :: runs = 0
  end type

  !> One sparse field of many.
  type, bind(C) :: c_sparse_request
    type(c_grid) :: grid
    type(clsdf_band) :: band
    integer(c_int32_t) :: outputs = 0  !< CLSDF_SET(...); 0: the distance
    integer(c_int32_t) :: reserved = 0
  end type

  !> The caller's arrays for a sparse field, on the host. Elements that the field does not need stay as they are.
  type, bind(C) :: c_sparse_arrays
    integer(c_size_t) :: struct_size = 56
    type(c_ptr) :: bricks = c_null_ptr  !< [brick_room][3]
    integer(c_int64_t) :: brick_room = 0
    type(c_ptr) :: inside = c_null_ptr  !< [run_room]
    integer(c_int64_t) :: run_room = 0
    !> packed arrays of brick_room * 512 items, of the types that clsdf_output_describe() states; the triangle may be
    !> int32. The distance has one
    type(c_targets) :: values
  end type

  !> The counts that a run of a clsdf_sparse_plan writes. They are those of the whole field, also if the memory has less
  !> room.
  type, bind(C) :: clsdf_device_sparse_counts
    integer(c_int64_t) :: bricks = 0
    integer(c_int64_t) :: runs = 0
    !> 1: the memory holds the field; 0: it had too little room, and is undefined
    integer(c_int64_t) :: is_complete = 0
  end type

  !> The caller's memory of the device (cl_mem) for a sparse field, with room for what the plan has room for. Nothing
  !> overlaps. The offsets are bytes, multiples of 8. Memory without room may be null.
  type, bind(C) :: c_sparse_buffers
    integer(c_size_t) :: struct_size = 72
    type(c_ptr) :: counts = c_null_ptr  !< a clsdf_device_sparse_counts
    integer(c_int64_t) :: counts_offset = 0
    type(c_ptr) :: bricks = c_null_ptr  !< int64_t [bricks][3]
    integer(c_int64_t) :: bricks_offset = 0
    type(c_ptr) :: inside = c_null_ptr  !< clsdf_brick_run [runs]
    integer(c_int64_t) :: inside_offset = 0
    type(c_targets) :: values  !< packed, 512 items for each brick that there is room for, as in clsdf_sparse_arrays
  end type

  !> Whole layers of a sparse field's bricks. A brick of the grid has values if one of its samples is in the band, or if
  !> it has samples of both signs; all its 512 samples have them then. In each other brick all samples are beyond the
  !> band and have one sign: they are inside if a run of `inside` holds the brick. Bricks and runs are sorted by z, then
  !> y, then x.
  type, bind(C) :: c_sparse_slab
    integer(c_size_t) :: struct_size = 152
    type(c_grid) :: part  !< the layers: a block of whole bricks
    type(c_ptr) :: bricks = c_null_ptr  !< [brick_count][3]
    integer(c_int64_t) :: brick_count = 0  !< that have values
    type(c_ptr) :: inside = c_null_ptr  !< [run_count], of bricks without values
    integer(c_int64_t) :: run_count = 0
    type(c_targets) :: values  !< packed: brick n has the items [512 n, 512 (n + 1)), x fastest
  end type

  type, bind(C) :: c_field_description
    integer(c_size_t) :: struct_size = 152
    type(c_grid) :: grid
    type(clsdf_band) :: band
    integer(c_int32_t) :: sign = 3  !< CLSDF_SIGN_AUTOMATIC if a file of another program states none
    !> 1: distances and gradients are negated, also zeros and what lies beyond the band
    integer(c_int32_t) :: positive_inside = 0
    type(c_ptr) :: mesh_name = c_null_ptr  !< null: ""; of a field, lives as long as the field
    !> of CLSDF_SIGN_BELOW: its z; DBL_MAX, the default: none, or not known
    real(c_double) :: floor = 1.7976931348623157e308_c_double
  end type

  !> The pose of a body, whose points x are at R x + t.
  type, bind(C) :: c_pose
    real(c_double) :: rotation(9) = [1, 0, 0, 0, 1, 0, 0, 0, 1]  !< R, by rows
    real(c_double) :: translation(3) = 0
  end type

  type, bind(C) :: c_scene_options
    integer(c_size_t) :: struct_size = 24
    integer(c_int64_t) :: kept_bytes = -1  !< limit of the memory that is kept of each mesh; 0: none; -1: the default
    !> 0 or 1: from which bodies, the points of pairs and the triangles of results count. Numbers in messages count from
    !> 0
    integer(c_int32_t) :: index_base = 1
    !> CLSDF_SURFACE_GIVEN, the default: the distance is the least of the bodies'. CLSDF_SURFACE_OUTER: that to the
    !> surface of the union of the bodies that are on, within overlaps, too; each body's mesh is replaced by its own
    !> outer surface when it is added.
    integer(c_int32_t) :: surface = 0
  end type

  !> Which links are asked for.
  type, bind(C) :: c_link_options
    integer(c_int32_t) :: hits = 0  !< CLSDF_WALLS or CLSDF_FACES
    !> 1: also links with both ends outside and a body between them, a row from each end
    integer(c_int32_t) :: with_between = 0
  end type

  !> The caller's arrays for links, packed on the host; each may be null. Those up to `flags` have `room` rows.
  type, bind(C) :: c_link_arrays
    integer(c_int64_t) :: room = 0
    type(c_ptr) :: samples = c_null_ptr  !< [room][3], on the lattice: clsdf_grid.first counts
    type(c_ptr) :: directions = c_null_ptr  !< the number of the direction, from the mesh's index base on
    type(c_ptr) :: q = c_null_ptr  !< the part of the link up to the first wall, 0 to 1
    type(c_ptr) :: q_floats = c_null_ptr  !< the same in floats: neither 0 nor 1 by rounding; q or this
    !> the lowest of those met first, from the index base on; 0xFFFFFFFF plus the base: none. Its group is
    !> numbers[triangle - base] of clsdf_mesh_group_numbers()
    type(c_ptr) :: triangles = c_null_ptr
    type(c_ptr) :: counts = c_null_ptr  !< walls on the link
    type(c_ptr) :: flags = c_null_ptr  !< CLSDF_LINK_FILM ...
    type(c_ptr) :: inside = c_null_ptr  !< for each sample of the grid, x fastest: 1 if it is inside, else 0
    type(c_ptr) :: dense = c_null_ptr  !< [direction][z][y][x]: q, or -1 where there is no link; needs no room
    type(c_ptr) :: dense_floats = c_null_ptr  !< the same in floats; dense or this
  end type

  !> The number of links that a run of a clsdf_link_plan writes: that of the grid's links, also if the memory has less
  !> room.
  type, bind(C) :: clsdf_device_link_count
    integer(c_int64_t) :: links = 0
    !> 1: the memory holds all links; 0: there is too little room, and it is as before
    integer(c_int64_t) :: is_complete = 0
  end type

  !> The caller's memory of the device for links: arrays of any strides, of `room` items up to `flags`. An array without
  !> memory is not wanted; its count is 0 or the number of its items.
  type, bind(C) :: c_link_buffers
    integer(c_size_t) :: struct_size = 736
    integer(c_int64_t) :: room = 0
    type(c_ptr) :: count = c_null_ptr  !< a clsdf_device_link_count; may be null
    integer(c_int64_t) :: count_offset = 0  !< bytes, a multiple of 8
    type(c_array) :: samples  !< int32, an item is three
    type(c_array) :: directions  !< uint8, numbers from 0 on
    type(c_array) :: q  !< float64 or float32
    type(c_array) :: triangles  !< uint32 or int32
    type(c_array) :: counts  !< uint32 or int32
    type(c_array) :: flags  !< uint8
    type(c_array) :: inside  !< uint8, for each sample of the grid
    !> float64 or float32, [direction][z][y][x], an item a sample: q, or -1; needs no room here
    type(c_array) :: dense
  end type

  !> The caller's arrays for the edges of a grid along x, y and z, packed on the host; each may be null. There is one
  !> edge less than samples on the axis; x fastest. No two of them may overlap.
  type, bind(C) :: c_crossing_arrays
    !> along the axis, of the first wall from the end outside; NaN if the sides agree
    type(c_ptr) :: coordinates(3) = c_null_ptr
    type(c_ptr) :: triangles(3) = c_null_ptr  !< from the index base on; 0xFFFFFFFF plus the base: none
    type(c_ptr) :: counts(3) = c_null_ptr  !< walls on the edge, also where the sides agree
    type(c_ptr) :: inside = c_null_ptr  !< for each sample: 1 if it is inside, else 0
  end type

  !> A question about rays, and the arrays for the results, an item for each ray. An array without memory is not wanted;
  !> what is given decides what is looked for: the first hits alone, whether there is any, or all.
  type, bind(C) :: c_ray_request
    integer(c_size_t) :: struct_size = 384
    integer(c_int32_t) :: hits = 0  !< CLSDF_WALLS or CLSDF_FACES
    integer(c_int32_t) :: reserved = 0
    !> hits beyond are left out: in lengths of the direction, 0 to infinity
    real(c_double) :: limit = huge(1.0_c_double)
    !> components of an item of `t` and `triangles`: the first hits of a ray, ascending
    integer(c_int64_t) :: most = 1
    type(c_array) :: t  !< float64 or float32, in lengths of the direction; infinity if there is no further hit
    !> uint32 or int32, the lowest at that t; 0xffffffff (-1) if there is no further hit, with index base 1: 0
    type(c_array) :: triangles
    type(c_array) :: counts  !< uint32 or int32: all hits up to the limit
    type(c_array) :: any  !< uint8: 1 if there is a hit up to the limit, else 0
  end type

  !> The meaning of a cell's numbers.
  type, bind(C) :: clsdf_fraction_options
    integer(c_size_t) :: struct_size = 48
    integer(c_int32_t) :: part = 0  !< CLSDF_PART_SOLID ...
    integer(c_int32_t) :: walls = 0  !< CLSDF_WALL_ABOVE ...
    integer(c_int32_t) :: normals_into_solid = 0  !< 1: vector areas and normals point into the solid; 0: out of it
    integer(c_int32_t) :: areas_of_faces = 0  !< 1: areas are parts of a cell's face across the normal, as AMReX's
    !> 1: centroids in the mesh's space; 0: in cells from the middle, -0.5 to 0.5
    integer(c_int32_t) :: centroids_as_points = 0
    integer(c_int32_t) :: reserved = 0
    real(c_double) :: snap = 0  !< vertices so near to a plane between cells are moved onto it: in cells, 0 to 0.001
    real(c_double) :: no_surface_centroid = 0  !< of arrays: the surface's centroid in cells without surface
  end type

  !> A cell that the surface meets; cells lie between neighbouring samples.
  type, bind(C) :: clsdf_cell_fraction
    integer(c_int32_t) :: cell(3) = 0  !< the sample at its low corner, on the lattice: clsdf_grid.first counts
    integer(c_int32_t) :: pieces = 0  !< parts of the surface in the cell that are joined over edges
    real(c_double) :: volume = 0  !< of the part, as a fraction of the cell
    real(c_double) :: centroid(3) = 0
    real(c_double) :: area = 0  !< of the surface in the cell
    real(c_double) :: vector_area(3) = 0  !< the integral of its normal
    real(c_double) :: surface_centroid(3) = 0
    real(c_double) :: face_fractions(6) = 0  !< of the part in the low and high face across x, y and z
    real(c_double) :: face_centroids(2, 6) = 0  !< in these faces, along the two other axes in the order x, y, z
  end type

  !> A box of cells and the caller's arrays, on the host, each of which may be without memory: float64 or float32, but
  !> for the first two. Of cells they have one item less than the grid has samples along each axis; those of faces
  !> across an axis as many as samples along it.
  type, bind(C) :: c_fraction_request
    type(c_grid) :: grid
    type(c_array) :: types  !< uint8: CLSDF_CELL_EMPTY ...
    type(c_array) :: pieces  !< uint32, int32 or uint8
    type(c_array) :: volume  !< clamped to [0, 1], as face_fractions
    type(c_array) :: centroid  !< an item is three, as of the next but `area`
    type(c_array) :: area
    type(c_array) :: vector_area
    type(c_array) :: normal  !< the vector area divided by its length
    type(c_array) :: surface_centroid
    type(c_array) :: face_fractions(3)  !< across x, y, z
    type(c_array) :: face_centroids(3)  !< an item is two
  end type

  !> The caller's arrays for the members of clsdf_cell_fraction, each of which may be without memory, of any strides: up
  !> to the last `room` items, one for each cell that the surface meets; float64 or float32, but for the first two.
  type, bind(C) :: c_fraction_row_arrays
    integer(c_int64_t) :: room = 0
    type(c_array) :: cells  !< int32, an item is three
    type(c_array) :: pieces  !< uint32 or int32
    type(c_array) :: volume
    type(c_array) :: centroid  !< an item is three, as of the next but `area`
    type(c_array) :: area
    type(c_array) :: vector_area
    type(c_array) :: surface_centroid
    type(c_array) :: face_fractions  !< an item is six
    type(c_array) :: face_centroids  !< an item is twelve: two of each face
    !> uint8, for each cell of the grid, x fastest: 1 if it is wholly of the part; needs no room
    type(c_array) :: full
  end type

  !> An array in memory of CUDA: all bytes from its lowest one to its highest one.
  type, bind(C) :: c_cuda_array
    integer(c_int64_t) :: address = 0  !< of the lowest byte
    integer(c_int64_t) :: bytes = 0  !< at least 1
    !> The call comes after what this stream had to do before it; what the stream has to do later comes after the call.
    type(c_ptr) :: stream = c_null_ptr
    type(c_ptr) :: name = c_null_ptr  !< in messages; null: "the array"
    integer(c_int32_t) :: access = 0  !< CLSDF_CUDA_READ ...
    integer(c_int32_t) :: reserved = 0
  end type

  ! ---- Functions ----

  interface
    function c_version() bind(C, name="clsdf_version") result(value)
      import
      integer(c_int64_t) :: value
    end function
    function c_version_text() bind(C, name="clsdf_version_text") result(value)
      import
      type(c_ptr) :: value
    end function
    function c_status_name(status) bind(C, name="clsdf_status_name") result(value)
      import
      integer(c_int32_t), value :: status
      type(c_ptr) :: value
    end function
    function c_type_name(type) bind(C, name="clsdf_type_name") result(value)
      import
      integer(c_int32_t), value :: type
      type(c_ptr) :: value
    end function
    function c_sign_name(rule) bind(C, name="clsdf_sign_name") result(value)
      import
      integer(c_int32_t), value :: rule
      type(c_ptr) :: value
    end function
    function c_device_kind_name(kind) bind(C, name="clsdf_device_kind_name") result(value)
      import
      integer(c_int32_t), value :: kind
      type(c_ptr) :: value
    end function
    function c_device_source_name(source) bind(C, name="clsdf_device_source_name") result(value)
      import
      integer(c_int32_t), value :: source
      type(c_ptr) :: value
    end function
    function c_last_error() bind(C, name="clsdf_last_error") result(value)
      import
      type(c_ptr) :: value
    end function
    function c_last_opencl_error() bind(C, name="clsdf_last_opencl_error") result(value)
      import
      integer(c_int32_t) :: value
    end function
    subroutine c_set_last_error(message) bind(C, name="clsdf_set_last_error")
      import
      character(kind=c_char), intent(in) :: message(*)
    end subroutine
    subroutine c_devices_retain(devices) bind(C, name="clsdf_devices_retain")
      import
      type(c_ptr), value :: devices
    end subroutine
    subroutine c_devices_release(devices) bind(C, name="clsdf_devices_release")
      import
      type(c_ptr), value :: devices
    end subroutine
    subroutine c_device_retain(device) bind(C, name="clsdf_device_retain")
      import
      type(c_ptr), value :: device
    end subroutine
    subroutine c_device_release(device) bind(C, name="clsdf_device_release")
      import
      type(c_ptr), value :: device
    end subroutine
    subroutine c_mesh_retain(mesh) bind(C, name="clsdf_mesh_retain")
      import
      type(c_ptr), value :: mesh
    end subroutine
    subroutine c_mesh_release(mesh) bind(C, name="clsdf_mesh_release")
      import
      type(c_ptr), value :: mesh
    end subroutine
    subroutine c_transform_retain(transform) bind(C, name="clsdf_transform_retain")
      import
      type(c_ptr), value :: transform
    end subroutine
    subroutine c_transform_release(transform) bind(C, name="clsdf_transform_release")
      import
      type(c_ptr), value :: transform
    end subroutine
    subroutine c_scene_retain(scene) bind(C, name="clsdf_scene_retain")
      import
      type(c_ptr), value :: scene
    end subroutine
    subroutine c_scene_release(scene) bind(C, name="clsdf_scene_release")
      import
      type(c_ptr), value :: scene
    end subroutine
    subroutine c_plan_retain(plan) bind(C, name="clsdf_plan_retain")
      import
      type(c_ptr), value :: plan
    end subroutine
    subroutine c_plan_release(plan) bind(C, name="clsdf_plan_release")
      import
      type(c_ptr), value :: plan
    end subroutine
    subroutine c_sparse_plan_retain(plan) bind(C, name="clsdf_sparse_plan_retain")
      import
      type(c_ptr), value :: plan
    end subroutine
    subroutine c_sparse_plan_release(plan) bind(C, name="clsdf_sparse_plan_release")
      import
      type(c_ptr), value :: plan
    end subroutine
    subroutine c_point_plan_retain(plan) bind(C, name="clsdf_point_plan_retain")
      import
      type(c_ptr), value :: plan
    end subroutine
    subroutine c_point_plan_release(plan) bind(C, name="clsdf_point_plan_release")
      import
      type(c_ptr), value :: plan
    end subroutine
    subroutine c_link_plan_retain(plan) bind(C, name="clsdf_link_plan_retain")
      import
      type(c_ptr), value :: plan
    end subroutine
    subroutine c_link_plan_release(plan) bind(C, name="clsdf_link_plan_release")
      import
      type(c_ptr), value :: plan
    end subroutine
    subroutine c_field_retain(field) bind(C, name="clsdf_field_retain")
      import
      type(c_ptr), value :: field
    end subroutine
    subroutine c_field_release(field) bind(C, name="clsdf_field_release")
      import
      type(c_ptr), value :: field
    end subroutine
    subroutine c_sparse_field_retain(field) bind(C, name="clsdf_sparse_field_retain")
      import
      type(c_ptr), value :: field
    end subroutine
    subroutine c_sparse_field_release(field) bind(C, name="clsdf_sparse_field_release")
      import
      type(c_ptr), value :: field
    end subroutine
    subroutine c_points_retain(points) bind(C, name="clsdf_points_retain")
      import
      type(c_ptr), value :: points
    end subroutine
    subroutine c_points_release(points) bind(C, name="clsdf_points_release")
      import
      type(c_ptr), value :: points
    end subroutine
    subroutine c_cuda_device_retain(device) bind(C, name="clsdf_cuda_device_retain")
      import
      type(c_ptr), value :: device
    end subroutine
    subroutine c_cuda_device_release(device) bind(C, name="clsdf_cuda_device_release")
      import
      type(c_ptr), value :: device
    end subroutine
    subroutine c_cuda_memory_retain(memory) bind(C, name="clsdf_cuda_memory_retain")
      import
      type(c_ptr), value :: memory
    end subroutine
    subroutine c_cuda_memory_release(memory) bind(C, name="clsdf_cuda_memory_release")
      import
      type(c_ptr), value :: memory
    end subroutine
    subroutine c_cuda_arrays_retain(arrays) bind(C, name="clsdf_cuda_arrays_retain")
      import
      type(c_ptr), value :: arrays
    end subroutine
    subroutine c_cuda_arrays_release(arrays) bind(C, name="clsdf_cuda_arrays_release")
      import
      type(c_ptr), value :: arrays
    end subroutine
    subroutine c_thread_limit_retain(limit) bind(C, name="clsdf_thread_limit_retain")
      import
      type(c_ptr), value :: limit
    end subroutine
    subroutine c_thread_limit_release(limit) bind(C, name="clsdf_thread_limit_release")
      import
      type(c_ptr), value :: limit
    end subroutine
    function c_output_count() bind(C, name="clsdf_output_count") result(value)
      import
      integer(c_int64_t) :: value
    end function
    function c_output_describe(output, info) bind(C, name="clsdf_output_describe") result(value)
      import
      integer(c_int32_t), value :: output
      type(c_output_info), intent(inout) :: info
      integer(c_int32_t) :: value
    end function
    function c_box_longest_side(box, side) bind(C, name="clsdf_box_longest_side") result(value)
      import
      type(clsdf_box), intent(in) :: box
      real(c_double), intent(inout) :: side
      integer(c_int32_t) :: value
    end function
    function c_length_resolve(length, voxel, extent, resolved) bind(C, name="clsdf_length_resolve") result(value)
      import
      type(clsdf_length), intent(in) :: length
      real(c_double), value :: voxel
      real(c_double), value :: extent
      real(c_double), intent(inout) :: resolved
      integer(c_int32_t) :: value
    end function
    function c_band_validate(band) bind(C, name="clsdf_band_validate") result(value)
      import
      type(clsdf_band), intent(in) :: band
      integer(c_int32_t) :: value
    end function
    function c_grid_around_box(box, options, grid) bind(C, name="clsdf_grid_around_box") result(value)
      import
      type(clsdf_box), intent(in) :: box
      type(c_grid_options), intent(in) :: options
      type(c_grid), intent(inout) :: grid
      integer(c_int32_t) :: value
    end function
    function c_grid_around_mesh(mesh, resolution, band, grid) bind(C, name="clsdf_grid_around_mesh") result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int64_t), value :: resolution
      type(clsdf_band), intent(in) :: band
      type(c_grid), intent(inout) :: grid
      integer(c_int32_t) :: value
    end function
    function c_grid_between(box, division, grid) bind(C, name="clsdf_grid_between") result(value)
      import
      type(clsdf_box), intent(in) :: box
      type(c_grid_division), intent(in) :: division
      type(c_grid), intent(inout) :: grid
      integer(c_int32_t) :: value
    end function
    function c_grid_part(grid, offset, size, result) bind(C, name="clsdf_grid_part") result(value)
      import
      type(c_grid), intent(in) :: grid
      integer(c_int64_t), intent(in) :: offset(*)
      integer(c_int64_t), intent(in) :: size(*)
      type(c_grid), intent(inout) :: result
      integer(c_int32_t) :: value
    end function
    function c_grid_block(grid, first, size, result) bind(C, name="clsdf_grid_block") result(value)
      import
      type(c_grid), intent(in) :: grid
      integer(c_int64_t), intent(in) :: first(*)
      integer(c_int64_t), intent(in) :: size(*)
      type(c_grid), intent(inout) :: result
      integer(c_int32_t) :: value
    end function
    function c_grid_grown(grid, samples, result) bind(C, name="clsdf_grid_grown") result(value)
      import
      type(c_grid), intent(in) :: grid
      integer(c_int64_t), value :: samples
      type(c_grid), intent(inout) :: result
      integer(c_int32_t) :: value
    end function
    function c_grid_refined(grid, ratio, result) bind(C, name="clsdf_grid_refined") result(value)
      import
      type(c_grid), intent(in) :: grid
      integer(c_int64_t), value :: ratio
      type(c_grid), intent(inout) :: result
      integer(c_int32_t) :: value
    end function
    function c_grid_refined_cells(grid, ratio, result) bind(C, name="clsdf_grid_refined_cells") result(value)
      import
      type(c_grid), intent(in) :: grid
      integer(c_int64_t), value :: ratio
      type(c_grid), intent(inout) :: result
      integer(c_int32_t) :: value
    end function
    function c_grid_in_whole_bricks(grid, result) bind(C, name="clsdf_grid_in_whole_bricks") result(value)
      import
      type(c_grid), intent(in) :: grid
      type(c_grid), intent(inout) :: result
      integer(c_int32_t) :: value
    end function
    function c_grid_cell_centred(grid, result) bind(C, name="clsdf_grid_cell_centred") result(value)
      import
      type(c_grid), intent(in) :: grid
      type(c_grid), intent(inout) :: result
      integer(c_int32_t) :: value
    end function
    function c_grid_position(grid, i, j, k, position) bind(C, name="clsdf_grid_position") result(value)
      import
      type(c_grid), intent(in) :: grid
      integer(c_int64_t), value :: i
      integer(c_int64_t), value :: j
      integer(c_int64_t), value :: k
      real(c_double), intent(inout) :: position(*)
      integer(c_int32_t) :: value
    end function
    function c_grid_box(grid, box) bind(C, name="clsdf_grid_box") result(value)
      import
      type(c_grid), intent(in) :: grid
      type(clsdf_box), intent(inout) :: box
      integer(c_int32_t) :: value
    end function
    function c_grid_voxel(grid, voxel) bind(C, name="clsdf_grid_voxel") result(value)
      import
      type(c_grid), intent(in) :: grid
      real(c_double), intent(inout) :: voxel
      integer(c_int32_t) :: value
    end function
    function c_grid_sample_count(grid, count) bind(C, name="clsdf_grid_sample_count") result(value)
      import
      type(c_grid), intent(in) :: grid
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_grid_validate(grid) bind(C, name="clsdf_grid_validate") result(value)
      import
      type(c_grid), intent(in) :: grid
      integer(c_int32_t) :: value
    end function
    function c_devices_list(devices) bind(C, name="clsdf_devices_list") result(value)
      import
      type(c_ptr), intent(out) :: devices
      integer(c_int32_t) :: value
    end function
    function c_devices_count(devices) bind(C, name="clsdf_devices_count") result(value)
      import
      type(c_ptr), value :: devices
      integer(c_int64_t) :: value
    end function
    function c_devices_describe(devices, index, info) bind(C, name="clsdf_devices_describe") result(value)
      import
      type(c_ptr), value :: devices
      integer(c_int64_t), value :: index
      type(c_device_info), intent(inout) :: info
      integer(c_int32_t) :: value
    end function
    function c_device_strongest(device) bind(C, name="clsdf_device_strongest") result(value)
      import
      type(c_ptr), intent(out) :: device
      integer(c_int32_t) :: value
    end function
    function c_device_select(index_or_part, device) bind(C, name="clsdf_device_select") result(value)
      import
      character(kind=c_char), intent(in) :: index_or_part(*)
      type(c_ptr), intent(out) :: device
      integer(c_int32_t) :: value
    end function
    function c_device_automatic(device) bind(C, name="clsdf_device_automatic") result(value)
      import
      type(c_ptr), intent(out) :: device
      integer(c_int32_t) :: value
    end function
    function c_device_of_rank(rank, ranks, device) bind(C, name="clsdf_device_of_rank") result(value)
      import
      integer(c_int64_t), value :: rank
      integer(c_int64_t), value :: ranks
      type(c_ptr), intent(out) :: device
      integer(c_int32_t) :: value
    end function
    function c_device_from_handles(context, id, queue, device) bind(C, name="clsdf_device_from_handles") result(value)
      import
      type(c_ptr), value :: context
      type(c_ptr), value :: id
      type(c_ptr), value :: queue
      type(c_ptr), intent(out) :: device
      integer(c_int32_t) :: value
    end function
    function c_device_limited(device, limits, limited) bind(C, name="clsdf_device_limited") result(value)
      import
      type(c_ptr), value :: device
      type(c_device_limits), intent(in) :: limits
      type(c_ptr), intent(out) :: limited
      integer(c_int32_t) :: value
    end function
    function c_device_describe(device, info) bind(C, name="clsdf_device_describe") result(value)
      import
      type(c_ptr), value :: device
      type(c_device_info), intent(inout) :: info
      integer(c_int32_t) :: value
    end function
    function c_device_handles(device, context, id, queue) bind(C, name="clsdf_device_handles") result(value)
      import
      type(c_ptr), value :: device
      type(c_ptr), intent(out) :: context
      type(c_ptr), intent(out) :: id
      type(c_ptr), intent(out) :: queue
      integer(c_int32_t) :: value
    end function
    function c_device_import_memory(device, descriptor, bytes, memory) bind(C, name="clsdf_device_import_memory") &
        result(value)
      import
      type(c_ptr), value :: device
      integer(c_int32_t), value :: descriptor
      integer(c_int64_t), value :: bytes
      type(c_ptr), intent(out) :: memory
      integer(c_int32_t) :: value
    end function
    function c_device_keep_records(device, folder) bind(C, name="clsdf_device_keep_records") result(value)
      import
      type(c_ptr), value :: device
      character(kind=c_char), intent(in) :: folder(*)
      integer(c_int32_t) :: value
    end function
    function c_device_read_programs(device, folder) bind(C, name="clsdf_device_read_programs") result(value)
      import
      type(c_ptr), value :: device
      character(kind=c_char), intent(in) :: folder(*)
      integer(c_int32_t) :: value
    end function
    function c_device_write_programs(device, folder) bind(C, name="clsdf_device_write_programs") result(value)
      import
      type(c_ptr), value :: device
      character(kind=c_char), intent(in) :: folder(*)
      integer(c_int32_t) :: value
    end function
    function c_device_forget_records(device) bind(C, name="clsdf_device_forget_records") result(value)
      import
      type(c_ptr), value :: device
      integer(c_int32_t) :: value
    end function
    function c_device_release_memory(device, bytes) bind(C, name="clsdf_device_release_memory") result(value)
      import
      type(c_ptr), value :: device
      integer(c_int64_t), intent(inout) :: bytes
      integer(c_int32_t) :: value
    end function
    function c_device_record_folder(device, text, size, length) bind(C, name="clsdf_device_record_folder") &
        result(value)
      import
      type(c_ptr), value :: device
      type(c_ptr), value :: text
      integer(c_int64_t), value :: size
      integer(c_int64_t), intent(inout) :: length
      integer(c_int32_t) :: value
    end function
    function c_default_record_folder(text, size, length) bind(C, name="clsdf_default_record_folder") result(value)
      import
      type(c_ptr), value :: text
      integer(c_int64_t), value :: size
      integer(c_int64_t), intent(inout) :: length
      integer(c_int32_t) :: value
    end function
    function c_limit_threads(count, limit) bind(C, name="clsdf_limit_threads") result(value)
      import
      integer(c_int64_t), value :: count
      type(c_ptr), intent(out) :: limit
      integer(c_int32_t) :: value
    end function
    function c_thread_count() bind(C, name="clsdf_thread_count") result(value)
      import
      integer(c_int64_t) :: value
    end function
    function c_mesh_create(arrays, mesh) bind(C, name="clsdf_mesh_create") result(value)
      import
      type(c_mesh_arrays), intent(in) :: arrays
      type(c_ptr), intent(out) :: mesh
      integer(c_int32_t) :: value
    end function
    function c_mesh_shape(name, mesh) bind(C, name="clsdf_mesh_shape") result(value)
      import
      character(kind=c_char), intent(in) :: name(*)
      type(c_ptr), intent(out) :: mesh
      integer(c_int32_t) :: value
    end function
    function c_mesh_read(path, mesh) bind(C, name="clsdf_mesh_read") result(value)
      import
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(out) :: mesh
      integer(c_int32_t) :: value
    end function
    function c_mesh_read_files(paths, count, options, mesh) bind(C, name="clsdf_mesh_read_files") result(value)
      import
      type(c_ptr), intent(in) :: paths(*)
      integer(c_int64_t), value :: count
      type(c_read_options), intent(in) :: options
      type(c_ptr), intent(out) :: mesh
      integer(c_int32_t) :: value
    end function
    function c_mesh_weld(mesh, welded) bind(C, name="clsdf_mesh_weld") result(value)
      import
      type(c_ptr), value :: mesh
      type(c_ptr), intent(out) :: welded
      integer(c_int32_t) :: value
    end function
    function c_mesh_weld_within(mesh, tolerance, welded) bind(C, name="clsdf_mesh_weld_within") result(value)
      import
      type(c_ptr), value :: mesh
      real(c_double), value :: tolerance
      type(c_ptr), intent(out) :: welded
      integer(c_int32_t) :: value
    end function
    function c_mesh_close_down(mesh, floor, closed) bind(C, name="clsdf_mesh_close_down") result(value)
      import
      type(c_ptr), value :: mesh
      real(c_double), value :: floor
      type(c_ptr), intent(out) :: closed
      integer(c_int32_t) :: value
    end function
    function c_mesh_describe_weld(mesh, welded, report, warning, size, length) bind(C, &
        name="clsdf_mesh_describe_weld") result(value)
      import
      type(c_ptr), value :: mesh
      type(c_ptr), value :: welded
      type(clsdf_weld_report), intent(inout) :: report
      type(c_ptr), value :: warning
      integer(c_int64_t), value :: size
      integer(c_int64_t), intent(inout) :: length
      integer(c_int32_t) :: value
    end function
    function c_mesh_write(mesh, path, colours, colour_count) bind(C, name="clsdf_mesh_write") result(value)
      import
      type(c_ptr), value :: mesh
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), value :: colours
      integer(c_int64_t), value :: colour_count
      integer(c_int32_t) :: value
    end function
    function c_shape_count() bind(C, name="clsdf_shape_count") result(value)
      import
      integer(c_int64_t) :: value
    end function
    function c_shape_name(index) bind(C, name="clsdf_shape_name") result(value)
      import
      integer(c_int64_t), value :: index
      type(c_ptr) :: value
    end function
    function c_shape_description(index) bind(C, name="clsdf_shape_description") result(value)
      import
      integer(c_int64_t), value :: index
      type(c_ptr) :: value
    end function
    function c_mesh_set_positions(mesh, positions) bind(C, name="clsdf_mesh_set_positions") result(value)
      import
      type(c_ptr), value :: mesh
      type(c_array), intent(in) :: positions
      integer(c_int32_t) :: value
    end function
    function c_mesh_set_index_base(mesh, index_base) bind(C, name="clsdf_mesh_set_index_base") result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int32_t), value :: index_base
      integer(c_int32_t) :: value
    end function
    function c_mesh_vertices(mesh, vertices, count) bind(C, name="clsdf_mesh_vertices") result(value)
      import
      type(c_ptr), value :: mesh
      type(c_ptr), intent(out) :: vertices
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_mesh_triangles(mesh, triangles, count) bind(C, name="clsdf_mesh_triangles") result(value)
      import
      type(c_ptr), value :: mesh
      type(c_ptr), intent(out) :: triangles
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_mesh_index_base(mesh, index_base) bind(C, name="clsdf_mesh_index_base") result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int32_t), intent(inout) :: index_base
      integer(c_int32_t) :: value
    end function
    function c_mesh_name(mesh, name) bind(C, name="clsdf_mesh_name") result(value)
      import
      type(c_ptr), value :: mesh
      type(c_ptr), intent(out) :: name
      integer(c_int32_t) :: value
    end function
    function c_mesh_group_count(mesh, count) bind(C, name="clsdf_mesh_group_count") result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_mesh_group_name(mesh, index, name) bind(C, name="clsdf_mesh_group_name") result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int64_t), value :: index
      type(c_ptr), intent(out) :: name
      integer(c_int32_t) :: value
    end function
    function c_mesh_group_numbers(mesh, numbers, count) bind(C, name="clsdf_mesh_group_numbers") result(value)
      import
      type(c_ptr), value :: mesh
      type(c_ptr), intent(out) :: numbers
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_mesh_set_groups(mesh, names, name_count, numbers, count) bind(C, name="clsdf_mesh_set_groups") &
        result(value)
      import
      type(c_ptr), value :: mesh
      type(c_ptr), intent(in) :: names(*)
      integer(c_int64_t), value :: name_count
      integer(c_int32_t), intent(in) :: numbers(*)
      integer(c_int64_t), value :: count
      integer(c_int32_t) :: value
    end function
    function c_mesh_box(mesh, box) bind(C, name="clsdf_mesh_box") result(value)
      import
      type(c_ptr), value :: mesh
      type(clsdf_box), intent(inout) :: box
      integer(c_int32_t) :: value
    end function
    function c_mesh_hash(mesh, hash) bind(C, name="clsdf_mesh_hash") result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int64_t), intent(inout) :: hash
      integer(c_int32_t) :: value
    end function
    function c_mesh_topology(mesh, topology) bind(C, name="clsdf_mesh_topology") result(value)
      import
      type(c_ptr), value :: mesh
      type(c_topology), intent(inout) :: topology
      integer(c_int32_t) :: value
    end function
    function c_mesh_defects(mesh, defects) bind(C, name="clsdf_mesh_defects") result(value)
      import
      type(c_ptr), value :: mesh
      type(clsdf_defects), intent(inout) :: defects
      integer(c_int32_t) :: value
    end function
    function c_mesh_sign(mesh, asked, rule, warning, size, length) bind(C, name="clsdf_mesh_sign") result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int32_t), value :: asked
      integer(c_int32_t), intent(inout) :: rule
      type(c_ptr), value :: warning
      integer(c_int64_t), value :: size
      integer(c_int64_t), intent(inout) :: length
      integer(c_int32_t) :: value
    end function
    function c_mesh_outer(mesh, sign, call, outer, report) bind(C, name="clsdf_mesh_outer") result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int32_t), value :: sign
      type(c_ptr), value :: call
      type(c_ptr), intent(out) :: outer
      type(clsdf_outer_report), intent(inout) :: report
      integer(c_int32_t) :: value
    end function
    function c_mesh_given_faces(mesh, faces, count) bind(C, name="clsdf_mesh_given_faces") result(value)
      import
      type(c_ptr), value :: mesh
      type(c_ptr), intent(out) :: faces
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_mesh_given_bodies(mesh, bodies, count) bind(C, name="clsdf_mesh_given_bodies") result(value)
      import
      type(c_ptr), value :: mesh
      type(c_ptr), intent(out) :: bodies
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_transform_create(device, mesh, options, call, transform) bind(C, name="clsdf_transform_create") &
        result(value)
      import
      type(c_ptr), value :: device
      type(c_ptr), value :: mesh
      type(c_transform_options), intent(in) :: options
      type(c_ptr), value :: call
      type(c_ptr), intent(out) :: transform
      integer(c_int32_t) :: value
    end function
    function c_transform_from_arrays(device, arrays, options, call, transform) bind(C, &
        name="clsdf_transform_from_arrays") result(value)
      import
      type(c_ptr), value :: device
      type(c_mesh_arrays), intent(in) :: arrays
      type(c_transform_options), intent(in) :: options
      type(c_ptr), value :: call
      type(c_ptr), intent(out) :: transform
      integer(c_int32_t) :: value
    end function
    function c_transform_restrict(transform, regions, count, restricted) bind(C, name="clsdf_transform_restrict") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(clsdf_region), intent(in) :: regions(*)
      integer(c_int64_t), value :: count
      type(c_ptr), intent(out) :: restricted
      integer(c_int32_t) :: value
    end function
    function c_transform_restrict_with_margin(transform, regions, count, margin, restricted) bind(C, &
        name="clsdf_transform_restrict_with_margin") result(value)
      import
      type(c_ptr), value :: transform
      type(clsdf_region), intent(in) :: regions(*)
      integer(c_int64_t), value :: count
      real(c_double), value :: margin
      type(c_ptr), intent(out) :: restricted
      integer(c_int32_t) :: value
    end function
    function c_transform_part_vertices(transform, vertices, room, count) bind(C, name="clsdf_transform_part_vertices") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_ptr), value :: vertices
      integer(c_int64_t), value :: room
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_transform_part_bytes(transform, bytes, room, count) bind(C, name="clsdf_transform_part_bytes") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_ptr), value :: bytes
      integer(c_int64_t), value :: room
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_transform_from_part(device, bytes, count, index_base, kept_bytes, transform) bind(C, &
        name="clsdf_transform_from_part") result(value)
      import
      type(c_ptr), value :: device
      integer(c_int8_t), intent(in) :: bytes(*)
      integer(c_int64_t), value :: count
      integer(c_int32_t), value :: index_base
      integer(c_int64_t), value :: kept_bytes
      type(c_ptr), intent(out) :: transform
      integer(c_int32_t) :: value
    end function
    function c_transform_prepared_bytes(transform, bytes) bind(C, name="clsdf_transform_prepared_bytes") result(value)
      import
      type(c_ptr), value :: transform
      integer(c_int64_t), intent(inout) :: bytes
      integer(c_int32_t) :: value
    end function
    function c_transform_share(transform, memory, bytes) bind(C, name="clsdf_transform_share") result(value)
      import
      type(c_ptr), value :: transform
      type(c_ptr), value :: memory
      integer(c_int64_t), value :: bytes
      integer(c_int32_t) :: value
    end function
    function c_transform_from_shared(device, memory, bytes, index_base, kept_bytes, transform) bind(C, &
        name="clsdf_transform_from_shared") result(value)
      import
      type(c_ptr), value :: device
      type(c_ptr), value :: memory
      integer(c_int64_t), value :: bytes
      integer(c_int32_t), value :: index_base
      integer(c_int64_t), value :: kept_bytes
      type(c_ptr), intent(out) :: transform
      integer(c_int32_t) :: value
    end function
    function c_transform_set_positions(transform, positions, call) bind(C, name="clsdf_transform_set_positions") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_array), intent(in) :: positions
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_transform_set_motion(transform, rotation, translation) bind(C, name="clsdf_transform_set_motion") &
        result(value)
      import
      type(c_ptr), value :: transform
      real(c_double), intent(in) :: rotation(*)
      real(c_double), intent(in) :: translation(*)
      integer(c_int32_t) :: value
    end function
    function c_transform_box(transform, box) bind(C, name="clsdf_transform_box") result(value)
      import
      type(c_ptr), value :: transform
      type(clsdf_box), intent(inout) :: box
      integer(c_int32_t) :: value
    end function
    function c_transform_topology(transform, topology) bind(C, name="clsdf_transform_topology") result(value)
      import
      type(c_ptr), value :: transform
      type(c_topology), intent(inout) :: topology
      integer(c_int32_t) :: value
    end function
    function c_transform_sign(transform, rule) bind(C, name="clsdf_transform_sign") result(value)
      import
      type(c_ptr), value :: transform
      integer(c_int32_t), intent(inout) :: rule
      integer(c_int32_t) :: value
    end function
    function c_transform_index_base(transform, index_base) bind(C, name="clsdf_transform_index_base") result(value)
      import
      type(c_ptr), value :: transform
      integer(c_int32_t), intent(inout) :: index_base
      integer(c_int32_t) :: value
    end function
    function c_transform_device(transform, device) bind(C, name="clsdf_transform_device") result(value)
      import
      type(c_ptr), value :: transform
      type(c_ptr), intent(out) :: device
      integer(c_int32_t) :: value
    end function
    function c_transform_memory(transform, memory) bind(C, name="clsdf_transform_memory") result(value)
      import
      type(c_ptr), value :: transform
      type(clsdf_kept_memory), intent(inout) :: memory
      integer(c_int32_t) :: value
    end function
    function c_transform_compile(transform, grid, band, outputs, call, statistics) bind(C, &
        name="clsdf_transform_compile") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      integer(c_int32_t), value :: outputs
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_compute(transform, grid, band, targets, target_count, call, statistics) bind(C, name="clsdf_compute") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      type(c_target), intent(in) :: targets(*)
      integer(c_int64_t), value :: target_count
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_compute_requests(transform, requests, count, call, statistics) bind(C, name="clsdf_compute_requests") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_request), intent(in) :: requests(*)
      integer(c_int64_t), value :: count
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_compute_blocks(transform, blocks, call, statistics) bind(C, name="clsdf_compute_blocks") result(value)
      import
      type(c_ptr), value :: transform
      type(c_block_set), intent(in) :: blocks
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_compute_slabs(transform, grid, band, outputs, sink, user, options, call, statistics) bind(C, &
        name="clsdf_compute_slabs") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      integer(c_int32_t), value :: outputs
      type(c_funptr), value :: sink
      type(c_ptr), value :: user
      type(c_ptr), value :: options
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_compute_field(transform, grid, band, outputs, call, statistics, field) bind(C, &
        name="clsdf_compute_field") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      integer(c_int32_t), value :: outputs
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      type(c_ptr), intent(out) :: field
      integer(c_int32_t) :: value
    end function
    function c_slabs_of(grid, slabs, size, count) bind(C, name="clsdf_slabs_of") result(value)
      import
      type(c_grid), intent(in) :: grid
      type(c_grid), intent(inout) :: slabs(*)
      integer(c_int64_t), value :: size
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_compute_sparse(transform, grid, band, arrays, call, statistics, counts) bind(C, &
        name="clsdf_compute_sparse") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      type(c_sparse_arrays), intent(in) :: arrays
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      type(clsdf_sparse_counts), intent(inout) :: counts
      integer(c_int32_t) :: value
    end function
    function c_count_sparse(transform, grid, band, call, statistics, counts) bind(C, name="clsdf_count_sparse") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      type(clsdf_sparse_counts), intent(inout) :: counts
      integer(c_int32_t) :: value
    end function
    function c_compute_sparse_slabs(transform, grid, band, outputs, sink, user, call, statistics) bind(C, &
        name="clsdf_compute_sparse_slabs") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      integer(c_int32_t), value :: outputs
      type(c_funptr), value :: sink
      type(c_ptr), value :: user
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_compute_sparse_field(transform, grid, band, outputs, call, statistics, field) bind(C, &
        name="clsdf_compute_sparse_field") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      integer(c_int32_t), value :: outputs
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      type(c_ptr), intent(out) :: field
      integer(c_int32_t) :: value
    end function
    function c_compute_sparse_requests(transform, requests, count, call, statistics, fields) bind(C, &
        name="clsdf_compute_sparse_requests") result(value)
      import
      type(c_ptr), value :: transform
      type(c_sparse_request), intent(in) :: requests(*)
      integer(c_int64_t), value :: count
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      type(c_ptr), intent(inout) :: fields(*)
      integer(c_int32_t) :: value
    end function
    function c_field_create(description, outputs, field) bind(C, name="clsdf_field_create") result(value)
      import
      type(c_field_description), intent(in) :: description
      integer(c_int32_t), value :: outputs
      type(c_ptr), intent(out) :: field
      integer(c_int32_t) :: value
    end function
    function c_field_describe(field, description) bind(C, name="clsdf_field_describe") result(value)
      import
      type(c_ptr), value :: field
      type(c_field_description), intent(inout) :: description
      integer(c_int32_t) :: value
    end function
    function c_field_outputs(field, outputs) bind(C, name="clsdf_field_outputs") result(value)
      import
      type(c_ptr), value :: field
      integer(c_int32_t), intent(inout) :: outputs
      integer(c_int32_t) :: value
    end function
    function c_field_array(field, output, array) bind(C, name="clsdf_field_array") result(value)
      import
      type(c_ptr), value :: field
      integer(c_int32_t), value :: output
      type(c_array), intent(inout) :: array
      integer(c_int32_t) :: value
    end function
    function c_field_set_index_base(field, index_base) bind(C, name="clsdf_field_set_index_base") result(value)
      import
      type(c_ptr), value :: field
      integer(c_int32_t), value :: index_base
      integer(c_int32_t) :: value
    end function
    function c_field_set_groups(field, mesh) bind(C, name="clsdf_field_set_groups") result(value)
      import
      type(c_ptr), value :: field
      type(c_ptr), value :: mesh
      integer(c_int32_t) :: value
    end function
    function c_sparse_field_describe(field, description) bind(C, name="clsdf_sparse_field_describe") result(value)
      import
      type(c_ptr), value :: field
      type(c_field_description), intent(inout) :: description
      integer(c_int32_t) :: value
    end function
    function c_sparse_field_slab(field, slab) bind(C, name="clsdf_sparse_field_slab") result(value)
      import
      type(c_ptr), value :: field
      type(c_sparse_slab), intent(inout) :: slab
      integer(c_int32_t) :: value
    end function
    function c_sparse_field_set_index_base(field, index_base) bind(C, name="clsdf_sparse_field_set_index_base") &
        result(value)
      import
      type(c_ptr), value :: field
      integer(c_int32_t), value :: index_base
      integer(c_int32_t) :: value
    end function
    function c_sparse_find(slab, sample, number) bind(C, name="clsdf_sparse_find") result(value)
      import
      type(c_sparse_slab), intent(in) :: slab
      integer(c_int64_t), intent(in) :: sample(*)
      integer(c_int64_t), intent(inout) :: number
      integer(c_int32_t) :: value
    end function
    function c_sparse_distances(slab, band, samples, count, distances) bind(C, name="clsdf_sparse_distances") &
        result(value)
      import
      type(c_sparse_slab), intent(in) :: slab
      type(clsdf_band), intent(in) :: band
      integer(c_int64_t), intent(in) :: samples(*)
      integer(c_int64_t), value :: count
      real(c_float), intent(inout) :: distances(*)
      integer(c_int32_t) :: value
    end function
    function c_query(transform, points, half_width, targets, target_count, call, statistics) bind(C, &
        name="clsdf_query") result(value)
      import
      type(c_ptr), value :: transform
      type(c_array), intent(in) :: points
      real(c_double), value :: half_width
      type(c_target), intent(in) :: targets(*)
      integer(c_int64_t), value :: target_count
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_classify(transform, boxes, count, half_width, places) bind(C, name="clsdf_classify") result(value)
      import
      type(c_ptr), value :: transform
      type(clsdf_box), intent(in) :: boxes(*)
      integer(c_int64_t), value :: count
      real(c_double), value :: half_width
      integer(c_int8_t), intent(inout) :: places(*)
      integer(c_int32_t) :: value
    end function
    function c_winding(transform, points, results, call) bind(C, name="clsdf_winding") result(value)
      import
      type(c_ptr), value :: transform
      type(c_array), intent(in) :: points
      type(c_array), intent(in) :: results
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_points_read(path, points) bind(C, name="clsdf_points_read") result(value)
      import
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(out) :: points
      integer(c_int32_t) :: value
    end function
    function c_points_data(points, positions, count) bind(C, name="clsdf_points_data") result(value)
      import
      type(c_ptr), value :: points
      type(c_ptr), intent(out) :: positions
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_points_write(positions, count, results, result_count, path, outputs) bind(C, name="clsdf_points_write") &
        result(value)
      import
      real(c_double), intent(in) :: positions(*)
      integer(c_int64_t), value :: count
      type(c_target), intent(in) :: results(*)
      integer(c_int64_t), value :: result_count
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int32_t), value :: outputs
      integer(c_int32_t) :: value
    end function
    function c_points_check_path(path) bind(C, name="clsdf_points_check_path") result(value)
      import
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int32_t) :: value
    end function
    subroutine c_abandon_unfinished_files() bind(C, name="clsdf_abandon_unfinished_files")
      import
    end subroutine
    function c_pose_of_matrix(matrix, pose) bind(C, name="clsdf_pose_of_matrix") result(value)
      import
      real(c_double), intent(in) :: matrix(*)
      type(c_pose), intent(inout) :: pose
      integer(c_int32_t) :: value
    end function
    function c_scene_create(device, options, scene) bind(C, name="clsdf_scene_create") result(value)
      import
      type(c_ptr), value :: device
      type(c_scene_options), intent(in) :: options
      type(c_ptr), intent(out) :: scene
      integer(c_int32_t) :: value
    end function
    function c_scene_add(scene, mesh, sign, pose, call, body) bind(C, name="clsdf_scene_add") result(value)
      import
      type(c_ptr), value :: scene
      type(c_ptr), value :: mesh
      integer(c_int32_t), value :: sign
      type(c_pose), intent(in) :: pose
      type(c_ptr), value :: call
      integer(c_int64_t), intent(inout) :: body
      integer(c_int32_t) :: value
    end function
    function c_scene_add_instance(scene, of, pose, body) bind(C, name="clsdf_scene_add_instance") result(value)
      import
      type(c_ptr), value :: scene
      integer(c_int64_t), value :: of
      type(c_pose), intent(in) :: pose
      integer(c_int64_t), intent(inout) :: body
      integer(c_int32_t) :: value
    end function
    function c_scene_set_poses(scene, bodies, poses, count) bind(C, name="clsdf_scene_set_poses") result(value)
      import
      type(c_ptr), value :: scene
      type(c_ptr), value :: bodies
      type(c_pose), intent(in) :: poses(*)
      integer(c_int64_t), value :: count
      integer(c_int32_t) :: value
    end function
    function c_scene_set_positions(scene, body, positions, call) bind(C, name="clsdf_scene_set_positions") &
        result(value)
      import
      type(c_ptr), value :: scene
      integer(c_int64_t), value :: body
      type(c_array), intent(in) :: positions
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_scene_set_active(scene, body, active) bind(C, name="clsdf_scene_set_active") result(value)
      import
      type(c_ptr), value :: scene
      integer(c_int64_t), value :: body
      integer(c_int32_t), value :: active
      integer(c_int32_t) :: value
    end function
    function c_scene_size(scene, count) bind(C, name="clsdf_scene_size") result(value)
      import
      type(c_ptr), value :: scene
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_scene_active(scene, body, active) bind(C, name="clsdf_scene_active") result(value)
      import
      type(c_ptr), value :: scene
      integer(c_int64_t), value :: body
      integer(c_int32_t), intent(inout) :: active
      integer(c_int32_t) :: value
    end function
    function c_scene_pose(scene, body, pose) bind(C, name="clsdf_scene_pose") result(value)
      import
      type(c_ptr), value :: scene
      integer(c_int64_t), value :: body
      type(c_pose), intent(inout) :: pose
      integer(c_int32_t) :: value
    end function
    function c_scene_sign(scene, body, rule) bind(C, name="clsdf_scene_sign") result(value)
      import
      type(c_ptr), value :: scene
      integer(c_int64_t), value :: body
      integer(c_int32_t), intent(inout) :: rule
      integer(c_int32_t) :: value
    end function
    function c_scene_has_sign(scene, has_sign) bind(C, name="clsdf_scene_has_sign") result(value)
      import
      type(c_ptr), value :: scene
      integer(c_int32_t), intent(inout) :: has_sign
      integer(c_int32_t) :: value
    end function
    function c_scene_box(scene, box) bind(C, name="clsdf_scene_box") result(value)
      import
      type(c_ptr), value :: scene
      type(clsdf_box), intent(inout) :: box
      integer(c_int32_t) :: value
    end function
    function c_scene_memory(scene, memory) bind(C, name="clsdf_scene_memory") result(value)
      import
      type(c_ptr), value :: scene
      type(clsdf_kept_memory), intent(inout) :: memory
      integer(c_int32_t) :: value
    end function
    function c_scene_outer(scene, call, outer, report) bind(C, name="clsdf_scene_outer") result(value)
      import
      type(c_ptr), value :: scene
      type(c_ptr), value :: call
      type(c_ptr), intent(out) :: outer
      type(clsdf_outer_report), intent(inout) :: report
      integer(c_int32_t) :: value
    end function
    function c_scene_compute(scene, grid, band, targets, target_count, call, statistics) bind(C, &
        name="clsdf_scene_compute") result(value)
      import
      type(c_ptr), value :: scene
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      type(c_target), intent(in) :: targets(*)
      integer(c_int64_t), value :: target_count
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_scene_compute_field(scene, grid, band, outputs, call, statistics, field) bind(C, &
        name="clsdf_scene_compute_field") result(value)
      import
      type(c_ptr), value :: scene
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      integer(c_int32_t), value :: outputs
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      type(c_ptr), intent(out) :: field
      integer(c_int32_t) :: value
    end function
    function c_scene_query(scene, points, half_width, targets, target_count, own, call, statistics) bind(C, &
        name="clsdf_scene_query") result(value)
      import
      type(c_ptr), value :: scene
      type(c_array), intent(in) :: points
      real(c_double), value :: half_width
      type(c_target), intent(in) :: targets(*)
      integer(c_int64_t), value :: target_count
      type(c_ptr), value :: own
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_scene_query_pairs(scene, points, pairs, count, half_width, targets, target_count, call, statistics) &
        bind(C, name="clsdf_scene_query_pairs") result(value)
      import
      type(c_ptr), value :: scene
      type(c_array), intent(in) :: points
      integer(c_int32_t), intent(in) :: pairs(*)
      integer(c_int64_t), value :: count
      real(c_double), value :: half_width
      type(c_target), intent(in) :: targets(*)
      integer(c_int64_t), value :: target_count
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_scene_contains(scene, points, inside, call) bind(C, name="clsdf_scene_contains") result(value)
      import
      type(c_ptr), value :: scene
      type(c_array), intent(in) :: points
      integer(c_int8_t), intent(inout) :: inside(*)
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_scene_winding(scene, points, results, call) bind(C, name="clsdf_scene_winding") result(value)
      import
      type(c_ptr), value :: scene
      type(c_array), intent(in) :: points
      real(c_double), intent(inout) :: results(*)
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_scene_classify(scene, boxes, count, half_width, places) bind(C, name="clsdf_scene_classify") &
        result(value)
      import
      type(c_ptr), value :: scene
      type(clsdf_box), intent(in) :: boxes(*)
      integer(c_int64_t), value :: count
      real(c_double), value :: half_width
      integer(c_int8_t), intent(inout) :: places(*)
      integer(c_int32_t) :: value
    end function
    function c_stencil(name, code, directions, count) bind(C, name="clsdf_stencil") result(value)
      import
      character(kind=c_char), intent(in) :: name(*)
      character(kind=c_char), intent(in) :: code(*)
      integer(c_int32_t), intent(inout) :: directions(*)
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_links(transform, grid, directions, direction_count, options, arrays, call, statistics, count) bind(C, &
        name="clsdf_links") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      integer(c_int32_t), intent(in) :: directions(*)
      integer(c_int64_t), value :: direction_count
      type(c_link_options), intent(in) :: options
      type(c_link_arrays), intent(in) :: arrays
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_link_slabs(transform, grid, directions, direction_count, options, sink, user, call, statistics) bind(C, &
        name="clsdf_link_slabs") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      integer(c_int32_t), intent(in) :: directions(*)
      integer(c_int64_t), value :: direction_count
      type(c_link_options), intent(in) :: options
      type(c_funptr), value :: sink
      type(c_ptr), value :: user
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_count_links(transform, grid, directions, direction_count, options, call, count) bind(C, &
        name="clsdf_count_links") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      integer(c_int32_t), intent(in) :: directions(*)
      integer(c_int64_t), value :: direction_count
      type(c_link_options), intent(in) :: options
      type(c_ptr), value :: call
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_crossings(transform, grid, arrays, call, statistics) bind(C, name="clsdf_crossings") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      type(c_crossing_arrays), intent(in) :: arrays
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_rays(transform, origins, directions, request, call, statistics) bind(C, name="clsdf_rays") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_array), intent(in) :: origins
      type(c_array), intent(in) :: directions
      type(c_ray_request), intent(in) :: request
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_visible(transform, from, to, hits, visible, call, statistics) bind(C, name="clsdf_visible") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_array), intent(in) :: from
      type(c_array), intent(in) :: to
      integer(c_int32_t), value :: hits
      type(c_array), intent(in) :: visible
      type(c_ptr), value :: call
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_fraction_convention(name, options) bind(C, name="clsdf_fraction_convention") result(value)
      import
      character(kind=c_char), intent(in) :: name(*)
      type(clsdf_fraction_options), intent(inout) :: options
      integer(c_int32_t) :: value
    end function
    function c_fractions(mesh, sign, grids, grid_count, options, sink, user, call) bind(C, name="clsdf_fractions") &
        result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int32_t), value :: sign
      type(c_grid), intent(in) :: grids(*)
      integer(c_int64_t), value :: grid_count
      type(clsdf_fraction_options), intent(in) :: options
      type(c_funptr), value :: sink
      type(c_ptr), value :: user
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_fraction_arrays(mesh, sign, requests, request_count, options, call) bind(C, &
        name="clsdf_fraction_arrays") result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int32_t), value :: sign
      type(c_fraction_request), intent(in) :: requests(*)
      integer(c_int64_t), value :: request_count
      type(clsdf_fraction_options), intent(in) :: options
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_fraction_slabs(mesh, sign, grid, options, sink, user, call) bind(C, name="clsdf_fraction_slabs") &
        result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int32_t), value :: sign
      type(c_grid), intent(in) :: grid
      type(clsdf_fraction_options), intent(in) :: options
      type(c_funptr), value :: sink
      type(c_ptr), value :: user
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_count_fractions(mesh, sign, grid, options, call, count) bind(C, name="clsdf_count_fractions") &
        result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int32_t), value :: sign
      type(c_grid), intent(in) :: grid
      type(clsdf_fraction_options), intent(in) :: options
      type(c_ptr), value :: call
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_fraction_rows(mesh, sign, device, grid, arrays, options, call, count) bind(C, &
        name="clsdf_fraction_rows") result(value)
      import
      type(c_ptr), value :: mesh
      integer(c_int32_t), value :: sign
      type(c_ptr), value :: device
      type(c_grid), intent(in) :: grid
      type(c_fraction_row_arrays), intent(in) :: arrays
      type(clsdf_fraction_options), intent(in) :: options
      type(c_ptr), value :: call
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_plan_create(transform, grid, band, outputs, call, plan) bind(C, name="clsdf_plan_create") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      type(clsdf_band), intent(in) :: band
      integer(c_int32_t), value :: outputs
      type(c_ptr), value :: call
      type(c_ptr), intent(out) :: plan
      integer(c_int32_t) :: value
    end function
    function c_plan_create_requests(transform, requests, count, call, plan) bind(C, name="clsdf_plan_create_requests") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_request), intent(in) :: requests(*)
      integer(c_int64_t), value :: count
      type(c_ptr), value :: call
      type(c_ptr), intent(out) :: plan
      integer(c_int32_t) :: value
    end function
    function c_plan_create_blocks(transform, blocks, call, plan) bind(C, name="clsdf_plan_create_blocks") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_block_set), intent(in) :: blocks
      type(c_ptr), value :: call
      type(c_ptr), intent(out) :: plan
      integer(c_int32_t) :: value
    end function
    function c_plan_bytes_requests(transform, requests, count, call, bytes) bind(C, name="clsdf_plan_bytes_requests") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_request), intent(in) :: requests(*)
      integer(c_int64_t), value :: count
      type(c_ptr), value :: call
      integer(c_int64_t), intent(inout) :: bytes
      integer(c_int32_t) :: value
    end function
    function c_plan_bytes_blocks(transform, blocks, call, bytes) bind(C, name="clsdf_plan_bytes_blocks") result(value)
      import
      type(c_ptr), value :: transform
      type(c_block_set), intent(in) :: blocks
      type(c_ptr), value :: call
      integer(c_int64_t), intent(inout) :: bytes
      integer(c_int32_t) :: value
    end function
    function c_plan_enqueue(plan, queue, wait_list, wait_count, done) bind(C, name="clsdf_plan_enqueue") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: queue
      type(c_ptr), value :: wait_list
      integer(c_int64_t), value :: wait_count
      type(c_ptr), value :: done
      integer(c_int32_t) :: value
    end function
    function c_plan_enqueue_to(plan, queue, targets, count, wait_list, wait_count, done) bind(C, &
        name="clsdf_plan_enqueue_to") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: queue
      type(c_targets), intent(in) :: targets(*)
      integer(c_int64_t), value :: count
      type(c_ptr), value :: wait_list
      integer(c_int64_t), value :: wait_count
      type(c_ptr), value :: done
      integer(c_int32_t) :: value
    end function
    function c_plan_update(plan, transform, call) bind(C, name="clsdf_plan_update") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: transform
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_plan_update_grids(plan, transform, grids, count, call) bind(C, name="clsdf_plan_update_grids") &
        result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grids(*)
      integer(c_int64_t), value :: count
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_plan_update_requests(plan, transform, requests, count, call) bind(C, name="clsdf_plan_update_requests") &
        result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: transform
      type(c_request), intent(in) :: requests(*)
      integer(c_int64_t), value :: count
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_plan_update_blocks(plan, transform, blocks, call) bind(C, name="clsdf_plan_update_blocks") &
        result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: transform
      type(c_block_set), intent(in) :: blocks
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_plan_sign(plan, rule) bind(C, name="clsdf_plan_sign") result(value)
      import
      type(c_ptr), value :: plan
      integer(c_int32_t), intent(inout) :: rule
      integer(c_int32_t) :: value
    end function
    function c_plan_statistics(plan, statistics) bind(C, name="clsdf_plan_statistics") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_plan_request_count(plan, count) bind(C, name="clsdf_plan_request_count") result(value)
      import
      type(c_ptr), value :: plan
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_plan_request(plan, index, grid, band, targets, size, target_count) bind(C, name="clsdf_plan_request") &
        result(value)
      import
      type(c_ptr), value :: plan
      integer(c_int64_t), value :: index
      type(c_grid), intent(inout) :: grid
      type(clsdf_band), intent(inout) :: band
      type(c_target), intent(inout) :: targets(*)
      integer(c_int64_t), value :: size
      integer(c_int64_t), intent(inout) :: target_count
      integer(c_int32_t) :: value
    end function
    function c_sparse_plan_create(transform, request, room, call, plan) bind(C, name="clsdf_sparse_plan_create") &
        result(value)
      import
      type(c_ptr), value :: transform
      type(c_sparse_request), intent(in) :: request
      type(clsdf_sparse_counts), intent(in) :: room
      type(c_ptr), value :: call
      type(c_ptr), intent(out) :: plan
      integer(c_int32_t) :: value
    end function
    function c_sparse_plan_enqueue(plan, queue, buffers, wait_list, wait_count, done) bind(C, &
        name="clsdf_sparse_plan_enqueue") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: queue
      type(c_sparse_buffers), intent(in) :: buffers
      type(c_ptr), value :: wait_list
      integer(c_int64_t), value :: wait_count
      type(c_ptr), value :: done
      integer(c_int32_t) :: value
    end function
    function c_sparse_plan_update(plan, transform, call) bind(C, name="clsdf_sparse_plan_update") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: transform
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_sparse_plan_update_request(plan, transform, request, room, call) bind(C, &
        name="clsdf_sparse_plan_update_request") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: transform
      type(c_sparse_request), intent(in) :: request
      type(clsdf_sparse_counts), intent(in) :: room
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_sparse_plan_request(plan, request, room) bind(C, name="clsdf_sparse_plan_request") result(value)
      import
      type(c_ptr), value :: plan
      type(c_sparse_request), intent(inout) :: request
      type(clsdf_sparse_counts), intent(inout) :: room
      integer(c_int32_t) :: value
    end function
    function c_sparse_plan_sign(plan, rule) bind(C, name="clsdf_sparse_plan_sign") result(value)
      import
      type(c_ptr), value :: plan
      integer(c_int32_t), intent(inout) :: rule
      integer(c_int32_t) :: value
    end function
    function c_sparse_plan_statistics(plan, statistics) bind(C, name="clsdf_sparse_plan_statistics") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_link_plan_create(transform, grid, directions, direction_count, room, options, call, plan) bind(C, &
        name="clsdf_link_plan_create") result(value)
      import
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      integer(c_int32_t), intent(in) :: directions(*)
      integer(c_int64_t), value :: direction_count
      integer(c_int64_t), value :: room
      type(c_link_options), intent(in) :: options
      type(c_ptr), value :: call
      type(c_ptr), intent(out) :: plan
      integer(c_int32_t) :: value
    end function
    function c_link_plan_enqueue(plan, queue, buffers, wait_list, wait_count, done) bind(C, &
        name="clsdf_link_plan_enqueue") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: queue
      type(c_link_buffers), intent(in) :: buffers
      type(c_ptr), value :: wait_list
      integer(c_int64_t), value :: wait_count
      type(c_ptr), value :: done
      integer(c_int32_t) :: value
    end function
    function c_link_plan_update(plan, transform, call) bind(C, name="clsdf_link_plan_update") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: transform
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_link_plan_update_grid(plan, transform, grid, room, call) bind(C, name="clsdf_link_plan_update_grid") &
        result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: transform
      type(c_grid), intent(in) :: grid
      integer(c_int64_t), value :: room
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_link_plan_grid(plan, grid, room) bind(C, name="clsdf_link_plan_grid") result(value)
      import
      type(c_ptr), value :: plan
      type(c_grid), intent(inout) :: grid
      integer(c_int64_t), intent(inout) :: room
      integer(c_int32_t) :: value
    end function
    function c_link_plan_sign(plan, rule) bind(C, name="clsdf_link_plan_sign") result(value)
      import
      type(c_ptr), value :: plan
      integer(c_int32_t), intent(inout) :: rule
      integer(c_int32_t) :: value
    end function
    function c_link_plan_statistics(plan, statistics) bind(C, name="clsdf_link_plan_statistics") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_point_plan_create(transform, count, half_width, outputs, call, plan) bind(C, &
        name="clsdf_point_plan_create") result(value)
      import
      type(c_ptr), value :: transform
      integer(c_int64_t), value :: count
      real(c_double), value :: half_width
      integer(c_int32_t), value :: outputs
      type(c_ptr), value :: call
      type(c_ptr), intent(out) :: plan
      integer(c_int32_t) :: value
    end function
    function c_point_plan_enqueue(plan, queue, points, targets, target_count, status, wait_list, wait_count, done) &
        bind(C, name="clsdf_point_plan_enqueue") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: queue
      type(c_array), intent(in) :: points
      type(c_target), intent(in) :: targets(*)
      integer(c_int64_t), value :: target_count
      type(c_ptr), value :: status
      type(c_ptr), value :: wait_list
      integer(c_int64_t), value :: wait_count
      type(c_ptr), value :: done
      integer(c_int32_t) :: value
    end function
    function c_point_plan_update(plan, transform, call) bind(C, name="clsdf_point_plan_update") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: transform
      type(c_ptr), value :: call
      integer(c_int32_t) :: value
    end function
    function c_point_plan_count(plan, count) bind(C, name="clsdf_point_plan_count") result(value)
      import
      type(c_ptr), value :: plan
      integer(c_int64_t), intent(inout) :: count
      integer(c_int32_t) :: value
    end function
    function c_point_plan_sign(plan, rule) bind(C, name="clsdf_point_plan_sign") result(value)
      import
      type(c_ptr), value :: plan
      integer(c_int32_t), intent(inout) :: rule
      integer(c_int32_t) :: value
    end function
    function c_point_plan_statistics(plan, statistics) bind(C, name="clsdf_point_plan_statistics") result(value)
      import
      type(c_ptr), value :: plan
      type(c_ptr), value :: statistics
      integer(c_int32_t) :: value
    end function
    function c_cuda_device_create(device, cuda_device) bind(C, name="clsdf_cuda_device_create") result(value)
      import
      type(c_ptr), value :: device
      type(c_ptr), intent(out) :: cuda_device
      integer(c_int32_t) :: value
    end function
    function c_cuda_device_ordinal(device, ordinal) bind(C, name="clsdf_cuda_device_ordinal") result(value)
      import
      type(c_ptr), value :: device
      integer(c_int32_t), intent(inout) :: ordinal
      integer(c_int32_t) :: value
    end function
    function c_cuda_device_has_semaphores(device, has_semaphores) bind(C, name="clsdf_cuda_device_has_semaphores") &
        result(value)
      import
      type(c_ptr), value :: device
      integer(c_int32_t), intent(inout) :: has_semaphores
      integer(c_int32_t) :: value
    end function
    function c_cuda_device_release_memory(device, bytes) bind(C, name="clsdf_cuda_device_release_memory") &
        result(value)
      import
      type(c_ptr), value :: device
      integer(c_int64_t), intent(inout) :: bytes
      integer(c_int32_t) :: value
    end function
    function c_cuda_memory_create(device, bytes, memory) bind(C, name="clsdf_cuda_memory_create") result(value)
      import
      type(c_ptr), value :: device
      integer(c_int64_t), value :: bytes
      type(c_ptr), intent(out) :: memory
      integer(c_int32_t) :: value
    end function
    function c_cuda_memory_place(memory, address, bytes, buffer) bind(C, name="clsdf_cuda_memory_place") result(value)
      import
      type(c_ptr), value :: memory
      integer(c_int64_t), intent(inout) :: address
      integer(c_int64_t), intent(inout) :: bytes
      type(c_ptr), intent(out) :: buffer
      integer(c_int32_t) :: value
    end function
    function c_cuda_arrays_create(device, used, count, arrays) bind(C, name="clsdf_cuda_arrays_create") result(value)
      import
      type(c_ptr), value :: device
      type(c_cuda_array), intent(in) :: used(*)
      integer(c_int64_t), value :: count
      type(c_ptr), intent(out) :: arrays
      integer(c_int32_t) :: value
    end function
    function c_cuda_arrays_get(arrays, index, type, count, array) bind(C, name="clsdf_cuda_arrays_get") result(value)
      import
      type(c_ptr), value :: arrays
      integer(c_int64_t), value :: index
      integer(c_int32_t), value :: type
      integer(c_int64_t), value :: count
      type(c_array), intent(inout) :: array
      integer(c_int32_t) :: value
    end function
    function c_cuda_arrays_begin(arrays) bind(C, name="clsdf_cuda_arrays_begin") result(value)
      import
      type(c_ptr), value :: arrays
      integer(c_int32_t) :: value
    end function
    function c_cuda_arrays_end(arrays) bind(C, name="clsdf_cuda_arrays_end") result(value)
      import
      type(c_ptr), value :: arrays
      integer(c_int32_t) :: value
    end function
    function c_cuda_arrays_begin_run(arrays, queue, wait_list, wait_count, event) bind(C, &
        name="clsdf_cuda_arrays_begin_run") result(value)
      import
      type(c_ptr), value :: arrays
      type(c_ptr), value :: queue
      type(c_ptr), value :: wait_list
      integer(c_int64_t), value :: wait_count
      type(c_ptr), intent(out) :: event
      integer(c_int32_t) :: value
    end function
    function c_cuda_arrays_end_run(arrays, done) bind(C, name="clsdf_cuda_arrays_end_run") result(value)
      import
      type(c_ptr), value :: arrays
      type(c_ptr), value :: done
      integer(c_int32_t) :: value
    end function
    function c_cuda_arrays_abandon(arrays) bind(C, name="clsdf_cuda_arrays_abandon") result(value)
      import
      type(c_ptr), value :: arrays
      integer(c_int32_t) :: value
    end function
    function c_cuda_arrays_follow(arrays, streams, count) bind(C, name="clsdf_cuda_arrays_follow") result(value)
      import
      type(c_ptr), value :: arrays
      type(c_ptr), intent(in) :: streams(*)
      integer(c_int64_t), value :: count
      integer(c_int32_t) :: value
    end function
    function c_field_read(path, field) bind(C, name="clsdf_field_read") result(value)
      import
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(out) :: field
      integer(c_int32_t) :: value
    end function
    function c_field_missing_files(path, text, size, length) bind(C, name="clsdf_field_missing_files") result(value)
      import
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), value :: text
      integer(c_int64_t), value :: size
      integer(c_int64_t), intent(inout) :: length
      integer(c_int32_t) :: value
    end function
    function c_field_write(field, path) bind(C, name="clsdf_field_write") result(value)
      import
      type(c_ptr), value :: field
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int32_t) :: value
    end function
    function c_field_check_path(path, outputs) bind(C, name="clsdf_field_check_path") result(value)
      import
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int32_t), value :: outputs
      integer(c_int32_t) :: value
    end function
    subroutine c_field_writer_retain(writer) bind(C, name="clsdf_field_writer_retain")
      import
      type(c_ptr), value :: writer
    end subroutine
    subroutine c_field_writer_release(writer) bind(C, name="clsdf_field_writer_release")
      import
      type(c_ptr), value :: writer
    end subroutine
    function c_field_writer_create(path, description, outputs, writer) bind(C, name="clsdf_field_writer_create") &
        result(value)
      import
      character(kind=c_char), intent(in) :: path(*)
      type(c_field_description), intent(in) :: description
      integer(c_int32_t), value :: outputs
      type(c_ptr), intent(out) :: writer
      integer(c_int32_t) :: value
    end function
    function c_field_writer_append(writer, values, count, slices) bind(C, name="clsdf_field_writer_append") &
        result(value)
      import
      type(c_ptr), value :: writer
      type(c_target), intent(in) :: values(*)
      integer(c_int64_t), value :: count
      integer(c_int64_t), value :: slices
      integer(c_int32_t) :: value
    end function
    function c_field_writer_finish(writer) bind(C, name="clsdf_field_writer_finish") result(value)
      import
      type(c_ptr), value :: writer
      integer(c_int32_t) :: value
    end function
    function c_sparse_field_read(path, field) bind(C, name="clsdf_sparse_field_read") result(value)
      import
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(out) :: field
      integer(c_int32_t) :: value
    end function
    function c_sparse_field_write(field, path) bind(C, name="clsdf_sparse_field_write") result(value)
      import
      type(c_ptr), value :: field
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int32_t) :: value
    end function
    subroutine c_sparse_writer_retain(writer) bind(C, name="clsdf_sparse_writer_retain")
      import
      type(c_ptr), value :: writer
    end subroutine
    subroutine c_sparse_writer_release(writer) bind(C, name="clsdf_sparse_writer_release")
      import
      type(c_ptr), value :: writer
    end subroutine
    function c_sparse_writer_create(path, description, outputs, writer) bind(C, name="clsdf_sparse_writer_create") &
        result(value)
      import
      character(kind=c_char), intent(in) :: path(*)
      type(c_field_description), intent(in) :: description
      integer(c_int32_t), value :: outputs
      type(c_ptr), intent(out) :: writer
      integer(c_int32_t) :: value
    end function
    function c_sparse_writer_append(writer, slab) bind(C, name="clsdf_sparse_writer_append") result(value)
      import
      type(c_ptr), value :: writer
      type(c_sparse_slab), intent(in) :: slab
      integer(c_int32_t) :: value
    end function
    function c_sparse_writer_finish(writer) bind(C, name="clsdf_sparse_writer_finish") result(value)
      import
      type(c_ptr), value :: writer
      integer(c_int32_t) :: value
    end function
    subroutine c_io_abandon_unfinished_files() bind(C, name="clsdf_io_abandon_unfinished_files")
      import
    end subroutine
  end interface
end module
