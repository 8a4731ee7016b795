!> clsdf in Fortran 2008: exact signed distance fields of triangle meshes with OpenCL. docs/fortran.md has whole programs;
!> it stands on libclsdf_c, whose header clsdf.h states units, ranges, errors and threads of each call: clsdf_mesh_read
!> there is mesh%read here. A program compiles this file with its own compiler, or uses the module of gfortran that is
!> installed. The module clsdf_c (clsdf_c.f90; installed, a part of this file) declares C's interface for clsdf and clsdf_io.
!>
!> For other kinds and ranks the script repeat.py copies procedures in this file: change the pattern, not the copies.
!>
!> STATUS. Every procedure that can fail has the optional arguments stat, which is 0 or one of the numbers below, and
!> errmsg, which is defined only after an error. Without stat, an error writes its message and stops the program.
!>
!> HANDLES (clsdf_device, clsdf_mesh, clsdf_transform, clsdf_plan, clsdf_sparse_plan, clsdf_field, clsdf_sparse_field,
!> clsdf_thread_limit) are counted references: assignment makes another reference to the same object, and the end of a
!> variable gives its reference back. release() does so at once. A type that holds handles needs an assignment(=) of its
!> own, which assigns them one by one (gfortran 12 gives those of intrinsic assignment back twice).
!>
!> ARRAYS are used where they are, whatever their bounds and strides: nothing is copied. Components (of vectors) come
!> first or after the samples: x(3, n) or x(n, 3), gradient(3, i, j, k) or gradient(i, j, k, 3); of two readings the first
!> counts.
!>
!> INDICES count from 1: vertices, triangles (0: none within reach) and samples of a lattice. Scalars are real(8).
module clsdf
  use, intrinsic :: iso_c_binding
  use clsdf_c, clsdf_c_array => c_array, clsdf_c_target => c_target, clsdf_c_grid => c_grid, &
      clsdf_c_description => c_field_description, clsdf_c_sparse_slab => c_sparse_slab
  use, intrinsic :: iso_fortran_env, only: error_unit
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_positive_inf
  implicit none
  private

  public :: clsdf_device, clsdf_device_info, clsdf_mesh, clsdf_topology, clsdf_edge, clsdf_defects, clsdf_weld_report, &
      clsdf_outer_report, clsdf_transform, clsdf_scene, clsdf_pose, &
      clsdf_kept_memory, clsdf_plan, clsdf_point_plan, clsdf_sparse_plan, clsdf_sparse_buffers, clsdf_device_sparse_counts, &
      clsdf_link_plan, clsdf_link_buffers, clsdf_device_link_count, &
      clsdf_field, clsdf_sparse_field, clsdf_thread_limit
  public :: clsdf_array, clsdf_pinned, clsdf_target, clsdf_output_info, clsdf_box, clsdf_length, clsdf_band, &
      clsdf_grid, clsdf_region, clsdf_request, clsdf_block_set, clsdf_statistics, clsdf_progress, clsdf_call_options, &
      clsdf_slab, clsdf_slab_sink, clsdf_sparse_counts, clsdf_sparse_request, clsdf_sparse_slab, clsdf_sparse_sink, &
      clsdf_links, clsdf_link_sink, clsdf_crossings
  public :: clsdf_fraction_options, clsdf_fraction_request, clsdf_cell_fraction, clsdf_fraction_convention
  public :: clsdf_progress_procedure, clsdf_stop_procedure, clsdf_log_procedure, clsdf_slab_procedure, &
      clsdf_sparse_procedure, clsdf_link_procedure
  public :: clsdf_version, clsdf_version_text, clsdf_last_error, clsdf_last_opencl_error, clsdf_set_last_error, &
      clsdf_status_name, clsdf_type_name, clsdf_sign_name, clsdf_device_kind_name, &
      clsdf_device_source_name, clsdf_output_count, &
      clsdf_output_describe, clsdf_band_symmetric, clsdf_band_full, clsdf_band_signs_only, clsdf_infinity, &
      clsdf_length_resolve, clsdf_devices_list, clsdf_default_record_folder, clsdf_thread_count, clsdf_shape_count, &
      clsdf_shape_name, clsdf_shape_description, clsdf_slabs_of, clsdf_points_read, clsdf_points_write, &
      clsdf_points_check_path, clsdf_abandon_unfinished_files, clsdf_stencil
  ! For the module clsdf_io, not for programs.
  public :: clsdf_finish, clsdf_text, clsdf_outputs_mask, clsdf_targets_of_samples, clsdf_pack_for_c, clsdf_c_array, &
      clsdf_c_target, clsdf_c_grid, clsdf_c_description, clsdf_c_sparse_slab, clsdf_grid_for_c

  ! ---- Numbers ----

  !> The version of this file: MAJOR * 1000000 + MINOR * 1000 + PATCH.
  integer(c_int64_t), parameter, public :: CLSDF_MODULE_VERSION = 1000

  public :: CLSDF_OK, CLSDF_INVALID_MESH, CLSDF_UNREADABLE_INPUT, CLSDF_INVALID_ARGUMENT, CLSDF_NO_DEVICE, &
      CLSDF_DEVICE_FAILURE, CLSDF_OUT_OF_MEMORY, CLSDF_UNSUPPORTED, CLSDF_CANCELLED, CLSDF_OUTPUT_FAILURE, &
      CLSDF_WRONG_RESULTS, CLSDF_UNEXPECTED, CLSDF_OWN_STATUS
  public :: CLSDF_AUTOMATIC, CLSDF_FLOAT32, CLSDF_FLOAT64, CLSDF_INT32, CLSDF_INT64, CLSDF_UINT32, CLSDF_UINT64, CLSDF_UINT8
  ! Outputs, and their arrays in Fortran. Beyond the band vectors are NaN.
  public :: CLSDF_DISTANCE     !< real: signed; always computed
  public :: CLSDF_TRIANGLE     !< integer(4): the nearest triangle; 0 beyond the band
  public :: CLSDF_SITE         !< integer(1): its nearest part: 0 to 2 its vertices, 3 to 5 its edges, 6 its face; -1 beyond
  public :: CLSDF_CLOSEST      !< real(8), 3 components: position of the closest point
  public :: CLSDF_GRADIENT     !< real, 3 components: a unit vector
  public :: CLSDF_BARYCENTRIC  !< real, 2 components: the weights of the triangle's second and third vertex
  public :: CLSDF_OFFSET       !< real, 3 components: from the sample or point to the closest point
  public :: CLSDF_BODY         !< integer(4): of a scene: the body of the nearest triangle; 0 beyond the band
  public :: CLSDF_SIGN_AUTOMATIC, CLSDF_SIGN_NONZERO, CLSDF_SIGN_PARITY, CLSDF_SIGN_NONE, CLSDF_SIGN_SOLID_ANGLE, &
      CLSDF_SIGN_BELOW, CLSDF_SURFACE_GIVEN, CLSDF_SURFACE_OUTER
  public :: CLSDF_WITHIN, CLSDF_INSIDE, CLSDF_OUTSIDE, CLSDF_BEYOND, CLSDF_WALLS, CLSDF_FACES
  public :: CLSDF_PART_SOLID, CLSDF_PART_FLUID, CLSDF_WALL_ABOVE, CLSDF_WALL_SOLID, CLSDF_WALL_FLUID, CLSDF_CELL_EMPTY, &
      CLSDF_CELL_FULL, CLSDF_CELL_CUT
  public :: CLSDF_LINK_FILM, CLSDF_LINK_BETWEEN, CLSDF_LINK_SHEET, CLSDF_LINK_CLOSING
  public :: CLSDF_FOUND, CLSDF_NOT_FINITE, CLSDF_TOO_FAR, CLSDF_SIGN_OPEN
  public :: CLSDF_GPU, CLSDF_PROCESSOR, CLSDF_ACCELERATOR, CLSDF_OTHER_DEVICE, CLSDF_REGISTERED, CLSDF_BUNDLED, &
      CLSDF_UNREGISTERED, CLSDF_DEVICE_FILE
  public :: CLSDF_MESH_UNITS, CLSDF_VOXELS, CLSDF_EXTENT
  public :: CLSDF_COMPILING, CLSDF_COMPUTING, CLSDF_TESTING
  public :: CLSDF_BRICK_SIDE, CLSDF_BRICK_SAMPLES

  ! ---- Boxes, lengths, bands, grids ----

  !> clsdf_grid(origin, spacing, shape(phi), lbound(phi)): sample phi(i, j, k) lies at origin + ((i, j, k) - 1) * spacing.
  !> `first` are the lower bounds of an array phi for the grid; 1 if it is left out. So a grid is a block of a lattice of
  !> any extent, and sample (1, 1, 1) of the lattice lies at the origin.
  type :: clsdf_grid
    real(c_double) :: origin(3) = 0, spacing(3) = 1
    integer(c_int64_t) :: size(3) = 0, first(3) = 1
  contains
    procedure, private :: grid_around_mesh, grid_around_box
    generic :: around => grid_around_mesh, grid_around_box
    procedure :: between => grid_between
    procedure :: last => grid_last
    procedure, private :: grid_part, grid_part_4, grid_block, grid_block_4
    generic :: part => grid_part, grid_part_4
    generic :: block => grid_block, grid_block_4
    procedure :: grown => grid_grown
    procedure :: refined => grid_refined
    procedure :: refined_cells => grid_refined_cells
    procedure :: in_whole_bricks => grid_in_whole_bricks
    procedure :: cell_centred => grid_cell_centred
    procedure :: position => grid_position
    procedure :: box => grid_box
    procedure :: voxel => grid_voxel
    procedure :: sample_count => grid_sample_count
    procedure :: validate => grid_validate
  end type

  ! ---- Arrays and targets ----

  !> An array of the program, or a buffer of the device: clsdf_array(x), or clsdf_array(buffer, type, ...). A variable of
  !> the program in it must have the attribute target. The components are not for programs.
  type :: clsdf_array
    type(c_ptr) :: host = c_null_ptr, device = c_null_ptr
    integer(c_int32_t) :: type = CLSDF_AUTOMATIC, rank = 0
    integer(c_int64_t) :: shape(5) = 0, strides(5) = 0  ! bytes
    integer(c_int64_t) :: offset = 0, count = 0, component_stride = 0, block_stride = 0
    integer(c_int32_t) :: pinned = 0
  end type

  !> An output and the array that it is written to: clsdf_target(CLSDF_GRADIENT, g), with the attribute target for g.
  type :: clsdf_target
    integer(c_int32_t) :: output = -1
    type(clsdf_array) :: array
  end type

  !> A row of the table of outputs.
  type :: clsdf_output_info
    integer(c_int32_t) :: output = -1, type = CLSDF_AUTOMATIC
    integer(c_int64_t) :: components = 0
    character(:), allocatable :: name, description
  end type

  !> One box of many.
  type :: clsdf_request
    type(clsdf_grid) :: grid
    type(clsdf_band) :: band
    type(clsdf_target), allocatable :: targets(:)
  end type

  !> Equal blocks of one lattice. The block is the last dimension of arrays: phi(i, j, k, block).
  type :: clsdf_block_set
    type(clsdf_grid) :: lattice  !< its origin and spacing count
    type(clsdf_band) :: band
    integer(c_int64_t) :: size(3) = 0
    integer(c_int64_t), allocatable :: first(:, :)  !< (3, blocks): the first sample of each, on the lattice, from 1
    type(clsdf_target), allocatable :: targets(:)
  end type

  ! ---- Options and results of calls ----

  !> Options of one call. A procedure ends the call with a status that it sets to another number than 0, for instance
  !> CLSDF_CANCELLED; clsdf_set_last_error() sets the message. Its first argument is the options of the call: extend the
  !> type to hand data on. A procedure must not make or use a transform or plan of the same device.
  type :: clsdf_call_options
    procedure(clsdf_progress_procedure), pointer :: progress => null()  !< called between launches
    procedure(clsdf_stop_procedure), pointer :: should_stop => null()   !< asked there, too
    procedure(clsdf_log_procedure), pointer :: log => null()            !< warnings of this call
    type(c_ptr), allocatable :: wait_list(:)  !< cl_events after which the call uses the caller's memory
    logical :: refuse_unusable_points = .false.  !< query fails if a point is not finite or too far from the mesh
  end type

  abstract interface
    subroutine clsdf_progress_procedure(options, progress, status)
      import :: clsdf_call_options, clsdf_progress, c_int32_t
      class(clsdf_call_options), intent(inout) :: options
      type(clsdf_progress), intent(in) :: progress
      integer(c_int32_t), intent(inout) :: status
    end subroutine
    subroutine clsdf_stop_procedure(options, status)
      import :: clsdf_call_options, c_int32_t
      class(clsdf_call_options), intent(inout) :: options
      integer(c_int32_t), intent(inout) :: status
    end subroutine
    subroutine clsdf_log_procedure(options, message, status)
      import :: clsdf_call_options, c_int32_t
      class(clsdf_call_options), intent(inout) :: options
      character(*), intent(in) :: message
      integer(c_int32_t), intent(inout) :: status
    end subroutine
  end interface

  !> A slab of a field: whole slices, in memory that is there until the sink returns.
  type :: clsdf_slab
    type(clsdf_grid) :: part
    type(c_ptr) :: values = c_null_ptr  ! clsdf_target[count] of C
    integer(c_int64_t) :: count = 0
    integer(c_int32_t) :: index_base = 1  !< of its triangles: the transform's
  contains
    procedure, private :: slab_r4_3, slab_r4_4, slab_r8_3, slab_r8_4, slab_i4, slab_i1
    !> call slab%array(CLSDF_DISTANCE, phi): a pointer to the values of an output, with the lower bounds part%first.
    generic :: array => slab_r4_3, slab_r4_4, slab_r8_3, slab_r8_4, slab_i4, slab_i1
  end type

  !> What takes the slabs of transform%compute_slabs(): extend it with the data that it needs.
  type, abstract :: clsdf_slab_sink
  contains
    procedure(clsdf_slab_procedure), deferred :: take
  end type

  abstract interface
    !> A status other than 0 ends the call.
    subroutine clsdf_slab_procedure(sink, slab, status)
      import :: clsdf_slab_sink, clsdf_slab, c_int32_t
      class(clsdf_slab_sink), intent(inout) :: sink
      type(clsdf_slab), intent(in) :: slab
      integer(c_int32_t), intent(inout) :: status
    end subroutine
  end interface

  ! ---- Sparse fields ----

  !> One sparse field of many.
  type :: clsdf_sparse_request
    type(clsdf_grid) :: grid
    type(clsdf_band) :: band
    integer(c_int32_t), allocatable :: outputs(:)  !< the distance alone
  end type

  !> Whole layers of a sparse field's bricks, in memory that is there until the sink returns, or as long as the field. A
  !> brick has values if one of its samples is in the band, or if it has samples of both signs. In each other brick all
  !> samples are beyond the band and have one sign. Bricks and runs are sorted by z, then y, then x.
  type :: clsdf_sparse_slab
    type(clsdf_grid) :: part
    integer(c_int64_t) :: brick_count = 0, run_count = 0
    integer(c_int32_t) :: index_base = 1  !< of its triangles: the transform's
    type(clsdf_c_sparse_slab) :: c        ! for clsdf_io
  contains
    procedure :: bricks => sparse_bricks
    procedure :: inside => sparse_inside
    procedure, private :: sparse_r4_4, sparse_r4_5, sparse_r8_5, sparse_i4_4, sparse_i1_4
    !> call slab%array(CLSDF_DISTANCE, phi): a pointer to the values of an output, phi(8, 8, 8, brick).
    generic :: array => sparse_r4_4, sparse_r4_5, sparse_r8_5, sparse_i4_4, sparse_i1_4
    procedure :: find => sparse_find
    procedure :: distances => sparse_distances
  end type

  !> Takes the layers of transform%compute_sparse_slabs(): extend it with the data that it needs.
  type, abstract :: clsdf_sparse_sink
  contains
    procedure(clsdf_sparse_procedure), deferred :: take_sparse
  end type

  abstract interface
    !> A status other than 0 ends the call.
    subroutine clsdf_sparse_procedure(sink, slab, status)
      import :: clsdf_sparse_sink, clsdf_sparse_slab, c_int32_t
      class(clsdf_sparse_sink), intent(inout) :: sink
      type(clsdf_sparse_slab), intent(in) :: slab
      integer(c_int32_t), intent(inout) :: status
    end subroutine
  end interface

  ! ---- Devices ----

  type :: clsdf_device_info
    integer(c_int64_t) :: index = -1  !< in the list of devices, as the command and CLSDF_DEVICE count: from 0
    character(:), allocatable :: name, platform, version, driver
    character(:), allocatable :: why_not  !< why this library cannot use it; "" if it can
    integer(c_int64_t) :: compute_units = 0, clock_megahertz = 0, memory = 0, largest_allocation = 0, float_width = 0
    integer(c_int32_t) :: kind = CLSDF_OTHER_DEVICE
    logical :: fp64 = .false., atomics64 = .false.
    type(c_ptr) :: id = c_null_ptr
    integer(c_int32_t) :: source = CLSDF_REGISTERED  !< how it was found
    character(:), allocatable :: driver_file  !< the driver's if this library opened it; of CLSDF_DEVICE_FILE, the file
    !                                            in /dev; else ""
    character(:), allocatable :: only_if_named  !< why it is taken only if it is named, though it can be used; else ""
  end type

  type :: clsdf_device
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure :: automatic => device_automatic
    procedure :: strongest => device_strongest
    procedure :: select => device_select
    procedure :: of_rank => device_of_rank
    procedure :: from_handles => device_from_handles
    procedure :: limited => device_limited
    procedure :: describe => device_describe
    procedure :: handles => device_handles
    procedure :: import_memory => device_import_memory
    procedure :: keep_records => device_keep_records
    procedure :: read_programs => device_read_programs
    procedure :: write_programs => device_write_programs
    procedure :: forget_records => device_forget_records
    procedure :: release_memory => device_release_memory
    procedure :: record_folder => device_record_folder
    procedure :: is_set => device_is_set
    procedure :: release => device_release
    procedure, private :: device_assign
    generic :: assignment(=) => device_assign
    final :: device_end
  end type

  !> As long as it lives, the loops of the library on the host have fewer threads.
  type :: clsdf_thread_limit
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure :: set => limit_set
    procedure :: release => thread_limit_release
    procedure, private :: thread_limit_assign
    generic :: assignment(=) => thread_limit_assign
    final :: thread_limit_end
  end type

  ! ---- Meshes ----

  !> What the sign rule depends on.
  type :: clsdf_topology
    logical :: closed = .false., balanced = .false., inside_out = .false.
    integer(c_int64_t) :: open_edges = 0, unbalanced_edges = 0, non_manifold_edges = 0, repeated_vertex_faces = 0, &
        coincident_vertices = 0, unused_vertices = 0
    type(clsdf_edge), allocatable :: first_open(:), first_unbalanced(:)  !< at most five
    !> The numbers of faces count from 0.
    integer(c_int64_t) :: boundary_edges = 0, joined_vertices = 0, duplicate_faces = 0, uncounted_faces = 0, &
        reoriented_faces = 0, inner_wall_faces = 0, first_inner_wall_face = 0, parts = 0, &
        inward_parts = 0, first_inward_face = 0, nested_parts = 0, first_nested_face = 0, &
        tested_points = 0, doubtful_points = 0, inside_points = 0, unclear_parts = 0, first_unclear_face = 0, &
        double_sided_faces = 0, doubled_cavity_faces = 0, first_doubled_cavity_face = 0, sheet_faces = 0, &
        first_sheet_face = 0, enclosing_faces = 0, first_enclosing_face = 0, overlapping_parts = 0, &
        first_overlapping_face = 0, downward_faces = 0, first_downward_face = 0, rim_loops = 0, &
        overlapping_rim_edges = 0, detail_parts = 0, detail_faces = 0, first_detail_face = 0, &
        partial_faces = 0, hidden_faces = 0
  end type

  ! ---- Fractions of cells ----

  !> A box of cells and the arrays for them, each of which may be missing, as clsdf_array(volume). Arrays of cells have one
  !> item less than the grid has samples along each axis, those of faces across an axis as many as samples along it.
  type :: clsdf_fraction_request
    type(clsdf_grid) :: grid
    type(clsdf_array) :: types, pieces       !< integer(1): CLSDF_CELL_EMPTY ...; integer(1) or integer(4)
    type(clsdf_array) :: volume, area        !< real(4) or real(8), as those that follow
    type(clsdf_array) :: centroid, vector_area, normal, surface_centroid  !< three components
    type(clsdf_array) :: face_fractions(3)
    type(clsdf_array) :: face_centroids(3)   !< two components
  end type

  type :: clsdf_mesh
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure, private :: mesh_create, mesh_create_r4_i4, mesh_create_r4_i8, mesh_create_r8_i4, mesh_create_r8_i8
    generic :: create => mesh_create, mesh_create_r4_i4, mesh_create_r4_i8, mesh_create_r8_i4, mesh_create_r8_i8
    procedure :: shape => mesh_shape
    procedure, private :: mesh_read, mesh_read_files
    generic :: read => mesh_read, mesh_read_files
    procedure :: weld => mesh_weld
    procedure :: close_down => mesh_close_down
    procedure :: outer => mesh_outer
    procedure :: given_faces => mesh_given_faces
    procedure :: given_bodies => mesh_given_bodies
    procedure :: fractions => mesh_fractions
    procedure :: fraction_arrays => mesh_fraction_arrays
    procedure :: write => mesh_write
    procedure, private :: mesh_set_positions, mesh_set_positions_r4, mesh_set_positions_r8
    generic :: set_positions => mesh_set_positions, mesh_set_positions_r4, mesh_set_positions_r8
    procedure :: set_index_base => mesh_set_index_base
    procedure :: index_base => mesh_index_base
    procedure :: vertices => mesh_vertices
    procedure :: triangles => mesh_triangles
    procedure :: name => mesh_name
    procedure :: group_count => mesh_group_count
    procedure :: group_name => mesh_group_name
    procedure :: group_numbers => mesh_group_numbers
    procedure :: set_groups => mesh_set_groups
    procedure :: box => mesh_box
    procedure :: hash => mesh_hash
    procedure :: topology => mesh_topology
    procedure :: defects => mesh_defects
    procedure :: sign => mesh_sign
    procedure :: is_set => mesh_is_set
    procedure :: release => mesh_release
    procedure, private :: mesh_assign
    generic :: assignment(=) => mesh_assign
    final :: mesh_end
  end type

  ! ---- Links and crossings ----

  !> The links of a grid that meet the surface, by sample (z, y, x), then by direction.
  type :: clsdf_links
    integer(c_int32_t), allocatable :: samples(:, :)   !< (3, n), on the lattice, as grid%first counts
    integer(c_int8_t), allocatable :: directions(:)    !< the column of the direction, from 1 on
    real(c_double), allocatable :: q(:)                !< the part of the link up to the first wall, 0 to 1
    integer(c_int32_t), allocatable :: triangles(:)    !< the lowest of those met first; 0 at a film
    integer(c_int32_t), allocatable :: counts(:)       !< walls on the link
    integer(c_int8_t), allocatable :: flags(:)         !< CLSDF_LINK_FILM ...
    integer(c_int8_t), allocatable :: inside(:, :, :)  !< of each sample of the grid: 1 if it is inside, else 0
  end type

  !> Takes the links of the slabs of transform%link_slabs(): extend it with the data that it needs.
  type, abstract :: clsdf_link_sink
  contains
    procedure(clsdf_link_procedure), deferred :: take_links
  end type

  abstract interface
    !> part: the slab, whole slices of the grid. A status other than 0 ends the call.
    subroutine clsdf_link_procedure(sink, part, links, status)
      import :: clsdf_link_sink, clsdf_grid, clsdf_links, c_int32_t
      class(clsdf_link_sink), intent(inout) :: sink
      type(clsdf_grid), intent(in) :: part
      type(clsdf_links), intent(in) :: links
      integer(c_int32_t), intent(inout) :: status
    end subroutine
  end interface

  !> Where the edges of a grid along one axis meet walls; there is one less than samples on that axis.
  type :: clsdf_crossings
    real(c_double), allocatable :: coordinates(:, :, :)   !< along the axis; NaN if the sides agree
    integer(c_int32_t), allocatable :: triangles(:, :, :) !< 0: none
    integer(c_int32_t), allocatable :: counts(:, :, :)    !< walls on the edge, also where the sides agree
  end type

  ! ---- Transforms ----

  type :: clsdf_transform
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure, private :: transform_create, transform_from_arrays, transform_create_r4, transform_create_r8
    generic :: create => transform_create, transform_from_arrays, transform_create_r4, transform_create_r8
    procedure :: restrict => transform_restrict
    procedure :: part_bytes => transform_part_bytes
    procedure :: part_vertices => transform_part_vertices
    procedure :: create_from_part => transform_create_from_part
    procedure :: prepared_bytes => transform_prepared_bytes
    procedure :: share => transform_share
    procedure :: create_from_shared => transform_create_from_shared
    procedure, private :: set_positions_array, set_positions_r4, set_positions_r8
    generic :: set_positions => set_positions_array, set_positions_r4, set_positions_r8
    procedure :: set_motion => transform_set_motion
    procedure, private :: compute_targets, compute_r4, compute_r8, compute_requests
    generic :: compute => compute_targets, compute_r4, compute_r8, compute_requests
    procedure, private :: compute_block_set, compute_blocks_r4, compute_blocks_r8
    generic :: compute_blocks => compute_block_set, compute_blocks_r4, compute_blocks_r8
    procedure :: compute_slabs => transform_compute_slabs
    procedure :: compute_field => transform_compute_field
    procedure, private :: compute_sparse_targets, compute_sparse_distance
    generic :: compute_sparse => compute_sparse_targets, compute_sparse_distance
    procedure :: count_sparse => transform_count_sparse
    procedure :: compute_sparse_slabs => transform_compute_sparse_slabs
    procedure, private :: compute_sparse_one, compute_sparse_requests
    generic :: compute_sparse_field => compute_sparse_one, compute_sparse_requests
    procedure, private :: query_targets, query_r4, query_r8, query_xyz_r4, query_xyz_r8
    generic :: query => query_targets, query_r4, query_r8, query_xyz_r4, query_xyz_r8
    procedure :: classify => transform_classify
    procedure :: links => transform_links
    procedure :: link_slabs => transform_link_slabs
    procedure, private :: links_dense_r4, links_dense_r8
    generic :: links_dense => links_dense_r4, links_dense_r8
    procedure :: count_links => transform_count_links
    procedure :: crossings => transform_crossings
    procedure, private :: winding_targets, winding_r4, winding_r8
    generic :: winding => winding_targets, winding_r4, winding_r8
    procedure, private :: rays_r4, rays_r8, ray_hits_r4, ray_hits_r8, visible_r4, visible_r8
    generic :: rays => rays_r4, rays_r8
    generic :: ray_hits => ray_hits_r4, ray_hits_r8
    generic :: visible => visible_r4, visible_r8
    procedure :: box => transform_box
    procedure :: topology => transform_topology
    procedure :: sign => transform_sign
    procedure :: index_base => transform_index_base
    procedure :: device => transform_device
    procedure :: memory => transform_memory
    procedure :: compile => transform_compile
    procedure :: is_set => transform_is_set
    procedure :: release => transform_release
    procedure, private :: transform_assign
    generic :: assignment(=) => transform_assign
    final :: transform_end
  end type

  ! ---- Scenes: many bodies with poses, and points among them (docs/scenes.md) ----

  !> The pose of a body, whose points x are at matmul(rotation, x) + translation.
  type :: clsdf_pose
    real(c_double) :: rotation(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])
    real(c_double) :: translation(3) = 0
  contains
    procedure :: set_matrix => pose_set_matrix
  end type

  !> Bodies have numbers from 1, in the order in which they were added.
  type :: clsdf_scene
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure :: create => scene_create
    procedure :: add => scene_add
    procedure :: add_instance => scene_add_instance
    procedure, private :: scene_set_poses, scene_set_some_poses
    generic :: set_poses => scene_set_poses, scene_set_some_poses
    procedure, private :: scene_set_positions, scene_set_positions_r4, scene_set_positions_r8
    generic :: set_positions => scene_set_positions, scene_set_positions_r4, scene_set_positions_r8
    procedure :: set_active => scene_set_active
    procedure :: size => scene_size
    procedure :: is_active => scene_is_active
    procedure :: pose => scene_pose
    procedure :: sign => scene_sign
    procedure :: has_sign => scene_has_sign
    procedure :: box => scene_box
    procedure :: memory => scene_memory
    procedure :: outer => scene_outer
    procedure :: compute => scene_compute
    procedure :: compute_field => scene_compute_field
    procedure, private :: scene_query_targets, scene_query_r4, scene_query_r8
    generic :: query => scene_query_targets, scene_query_r4, scene_query_r8
    procedure, private :: scene_query_pairs, scene_query_pairs_r4, scene_query_pairs_r8
    generic :: query_pairs => scene_query_pairs, scene_query_pairs_r4, scene_query_pairs_r8
    procedure, private :: scene_contains, scene_contains_r4, scene_contains_r8
    generic :: contains => scene_contains, scene_contains_r4, scene_contains_r8
    procedure, private :: scene_winding, scene_winding_r4, scene_winding_r8
    generic :: winding => scene_winding, scene_winding_r4, scene_winding_r8
    procedure :: classify => scene_classify
    procedure :: is_set => scene_is_set
    procedure :: release => scene_release
    procedure, private :: scene_assign
    generic :: assignment(=) => scene_assign
    final :: scene_end
  end type

  ! ---- Plans: boxes that are computed again and again, into buffers of the device ----

  type :: clsdf_plan
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure, private :: plan_create_grid, plan_create_requests, plan_create_blocks
    generic :: create => plan_create_grid, plan_create_requests, plan_create_blocks
    procedure, nopass, private :: plan_bytes_requests, plan_bytes_blocks
    generic :: bytes => plan_bytes_requests, plan_bytes_blocks
    procedure :: enqueue => plan_enqueue
    procedure, private :: plan_enqueue_to, plan_enqueue_to_many
    generic :: enqueue_to => plan_enqueue_to, plan_enqueue_to_many
    procedure, private :: plan_update, plan_update_grids, plan_update_requests, plan_update_blocks
    generic :: update => plan_update, plan_update_grids, plan_update_requests, plan_update_blocks
    procedure :: sign => plan_sign
    procedure :: statistics => plan_statistics
    procedure :: request_count => plan_request_count
    procedure :: request => plan_request
    procedure :: is_set => plan_is_set
    procedure :: release => plan_release
    procedure, private :: plan_assign
    generic :: assignment(=) => plan_assign
    final :: plan_end
  end type

  !> The memory of the device for links: buffers, of `room` items up to `flags`, as clsdf_array(buffer, type). One without
  !> a buffer is not wanted. Numbers in these buffers are those of C: they count from 0.
  type :: clsdf_link_buffers
    integer(c_int64_t) :: room = 0
    type(c_ptr) :: count = c_null_ptr      !< a clsdf_device_link_count; may be c_null_ptr
    integer(c_int64_t) :: count_offset = 0  !< bytes, a multiple of 8
    type(clsdf_array) :: samples, directions, q, triangles, counts, flags
    type(clsdf_array) :: inside  !< bytes, one for each sample of the grid
    type(clsdf_array) :: dense   !< (nx, ny, nz, Q): q, or -1; needs no room here
  end type

  !> Links of a grid that go to memory of the device again and again.
  type :: clsdf_link_plan
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure :: create => link_plan_create
    procedure :: enqueue => link_plan_enqueue
    procedure, private :: link_plan_update, link_plan_update_grid
    generic :: update => link_plan_update, link_plan_update_grid
    procedure :: sign => link_plan_sign
    procedure :: statistics => link_plan_statistics
    procedure :: grid => link_plan_grid
    procedure :: is_set => link_plan_is_set
    procedure :: release => link_plan_release
    procedure, private :: link_plan_assign
    generic :: assignment(=) => link_plan_assign
    final :: link_plan_end
  end type

  !> The memory of the device (cl_mem) for a sparse field, with room for what the plan has room for. Nothing overlaps. The
  !> offsets are bytes, multiples of 8. Memory without room may be c_null_ptr. Indices in these buffers are those of C: they
  !> count from 0.
  type :: clsdf_sparse_buffers
    type(c_ptr) :: counts = c_null_ptr  !< a clsdf_device_sparse_counts
    type(c_ptr) :: bricks = c_null_ptr  !< integer(c_int64_t), (3, bricks)
    type(c_ptr) :: inside = c_null_ptr  !< integer(c_int64_t), (4, runs)
    integer(c_int64_t) :: counts_offset = 0, bricks_offset = 0, inside_offset = 0
    type(clsdf_target), allocatable :: values(:)  !< packed buffers, 512 samples for each brick that there is room for
  end type

  !> A sparse field that is computed again and again, and stays in memory of the device.
  type :: clsdf_sparse_plan
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure :: create => sparse_plan_create
    procedure :: enqueue => sparse_plan_enqueue
    procedure, private :: sparse_plan_update, sparse_plan_update_request
    generic :: update => sparse_plan_update, sparse_plan_update_request
    procedure :: sign => sparse_plan_sign
    procedure :: statistics => sparse_plan_statistics
    procedure :: request => sparse_plan_request
    procedure :: is_set => sparse_plan_is_set
    procedure :: release => sparse_plan_release
    procedure, private :: sparse_plan_assign
    generic :: assignment(=) => sparse_plan_assign
    final :: sparse_plan_end
  end type

  !> Points that are looked up again and again, in memory of the device.
  type :: clsdf_point_plan
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure :: create => point_plan_create
    procedure :: enqueue => point_plan_enqueue
    procedure :: update => point_plan_update
    procedure :: count => point_plan_count
    procedure :: sign => point_plan_sign
    procedure :: statistics => point_plan_statistics
    procedure :: is_set => point_plan_is_set
    procedure :: release => point_plan_release
    procedure, private :: point_plan_assign
    generic :: assignment(=) => point_plan_assign
    final :: point_plan_end
  end type

  ! ---- Fields in the library's memory ----

  type :: clsdf_field
    type(c_ptr) :: handle = c_null_ptr  ! for clsdf_io
  contains
    procedure :: create => field_create
    procedure :: describe => field_describe
    procedure :: outputs => field_outputs
    procedure, private :: field_r4_3, field_r4_4, field_r8_3, field_r8_4, field_i4, field_i1
    !> call field%array(CLSDF_DISTANCE, phi): a pointer to the field's own memory, with the lower bounds grid%first.
    generic :: array => field_r4_3, field_r4_4, field_r8_3, field_r8_4, field_i4, field_i1
    procedure :: set_groups => field_set_groups
    procedure :: is_set => field_is_set
    procedure :: release => field_release
    procedure, private :: field_assign
    generic :: assignment(=) => field_assign
    final :: field_end
  end type

  !> A sparse field.
  type :: clsdf_sparse_field
    type(c_ptr) :: handle = c_null_ptr  ! for clsdf_io
    integer(c_int32_t), private :: index_base = 1
  contains
    procedure :: describe => sparse_field_describe
    procedure :: slab => sparse_field_slab
    procedure :: set_index_base => sparse_field_set_index_base
    procedure :: is_set => sparse_field_is_set
    procedure :: release => sparse_field_release
    procedure, private :: sparse_field_assign
    generic :: assignment(=) => sparse_field_assign
    final :: sparse_field_end
  end type

  ! What a call hands to C, and keeps for its duration.
  type :: caller
    type(c_call_options) :: c
    class(clsdf_call_options), pointer :: options => null()
  end type
  type :: slab_taker
    class(clsdf_slab_sink), pointer :: sink => null()
    integer(c_int32_t) :: index_base = 1
  end type
  type :: sparse_taker
    class(clsdf_sparse_sink), pointer :: sink => null()
    integer(c_int32_t) :: index_base = 1
  end type
  type :: cell_taker
    type(clsdf_cell_fraction), allocatable :: cells(:)
  end type
  type :: link_taker
    class(clsdf_link_sink), pointer :: sink => null()
  end type
  type :: request_list
    type(c_request), allocatable :: items(:)
    type(clsdf_c_target), allocatable :: targets(:)
  end type
  type :: block_list
    type(c_block_set) :: c
    integer(c_int64_t), allocatable :: first(:, :)
    type(clsdf_c_target), allocatable :: targets(:)
  end type

  interface clsdf_array
    module procedure array_of_buffer, array_r4_1, array_r4_2, array_r4_3, array_r4_4, array_r4_5, array_r8_1, &
        array_r8_2, array_r8_3, array_r8_4, array_r8_5, array_i4_1, array_i4_2, array_i4_3, array_i4_4, &
        array_i8_2, array_i1_1, array_i1_3, array_i1_4
  end interface
  interface clsdf_target
    module procedure target_of_array, target_of_buffer, target_r4_1, target_r4_2, target_r4_3, target_r4_4, &
        target_r4_5, target_r8_1, target_r8_2, target_r8_3, target_r8_4, target_r8_5, target_i4_1, &
        target_i4_3, target_i4_4, target_i1_1, target_i1_3, target_i1_4
  end interface

  interface
    function c_strlen(text) bind(C, name="strlen") result(value)
      import
      integer(c_size_t) :: value
      type(c_ptr), value :: text
    end function
  end interface

contains

  ! ---- Version, numbers, errors ----

  !> The version of the library in use: CLSDF_MODULE_VERSION if it is that of this file.
  function clsdf_version() result(version)
    integer(c_int64_t) :: version
    version = c_version()
  end function

  function clsdf_version_text() result(text)
    character(:), allocatable :: text
    text = clsdf_text(c_version_text())
  end function

  !> The whole message of this thread's last call; "" after a success.
  function clsdf_last_error() result(text)
    character(:), allocatable :: text
    text = clsdf_text(c_last_error())
  end function

  function clsdf_last_opencl_error() result(code)
    integer(c_int32_t) :: code
    code = c_last_opencl_error()
  end function

  !> For procedures that end a call: its message.
  subroutine clsdf_set_last_error(message)
    character(*), intent(in) :: message
    call c_set_last_error(trim(message)//c_null_char)
  end subroutine

  function clsdf_status_name(status) result(text)
    integer(c_int32_t), intent(in) :: status
    character(:), allocatable :: text
    text = clsdf_text(c_status_name(status))
  end function

  function clsdf_type_name(type) result(text)
    integer(c_int32_t), intent(in) :: type
    character(:), allocatable :: text
    text = clsdf_text(c_type_name(type))
  end function

  function clsdf_sign_name(rule) result(text)
    integer(c_int32_t), intent(in) :: rule
    character(:), allocatable :: text
    text = clsdf_text(c_sign_name(rule))
  end function

  function clsdf_device_kind_name(kind) result(text)
    integer(c_int32_t), intent(in) :: kind
    character(:), allocatable :: text
    text = clsdf_text(c_device_kind_name(kind))
  end function

  function clsdf_device_source_name(source) result(text)
    integer(c_int32_t), intent(in) :: source
    character(:), allocatable :: text
    text = clsdf_text(c_device_source_name(source))
  end function

  !> A text of C; "" for null.
  function clsdf_text(first) result(text)
    type(c_ptr), intent(in) :: first
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: i
    if (.not. c_associated(first)) then
      text = ''
      return
    end if
    call c_f_pointer(first, letters, [c_strlen(first)])
    allocate (character(size(letters)) :: text)
    do i = 1, size(letters)
      text(i:i) = letters(i)
    end do
  end function

  !> Ends a call: hands the status on, or stops the program.
  subroutine clsdf_finish(status, stat, errmsg)
    integer(c_int32_t), intent(in) :: status
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    if (present(stat)) stat = status
    if (status == CLSDF_OK) return
    if (present(errmsg)) errmsg = clsdf_last_error()
    if (present(stat)) return
    write (error_unit, '(4a)') 'clsdf: ', clsdf_status_name(status), ': ', clsdf_last_error()
    error stop 1
  end subroutine

  function refused(message) result(status)
    character(*), intent(in) :: message
    integer(c_int32_t) :: status
    call clsdf_set_last_error(message)
    status = CLSDF_INVALID_ARGUMENT
  end function

  function clsdf_output_count() result(count)
    integer(c_int64_t) :: count
    count = c_output_count()
  end function

  !> Outputs are 0 to clsdf_output_count() - 1.
  subroutine clsdf_output_describe(output, info, stat, errmsg)
    integer(c_int32_t), intent(in) :: output
    type(clsdf_output_info), intent(out) :: info
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_output_info) :: c
    integer(c_int32_t) :: status
    c%struct_size = c_sizeof(c) + 1  ! calls fill it
    status = c_output_describe(output, c)
    info%output = c%output
    info%type = c%type
    info%components = c%components
    info%name = clsdf_text(c%name)
    info%description = clsdf_text(c%description)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The set of outputs as C has it; 0, the distance, if none are given.
  function clsdf_outputs_mask(outputs) result(mask)
    integer(c_int32_t), intent(in), optional :: outputs(:)
    integer(c_int32_t) :: mask
    integer :: i
    mask = 0
    if (.not. present(outputs)) return
    do i = 1, size(outputs)
      mask = ibset(mask, max(0, min(31, outputs(i))))
    end do
  end function

  ! ---- Bands and grids ----

  pure function clsdf_infinity() result(infinity)
    real(c_double) :: infinity
    infinity = ieee_value(infinity, ieee_positive_inf)
  end function

  !> huge(1d0) is no limit, as infinity.
  pure function without_limit(half_width) result(limit)
    real(c_double), intent(in) :: half_width
    real(c_double) :: limit
    limit = merge(clsdf_infinity(), half_width, half_width >= huge(half_width))
  end function

  pure function clsdf_band_symmetric(half_width) result(band)
    real(c_double), intent(in) :: half_width
    type(clsdf_band) :: band
    band = clsdf_band(without_limit(half_width), without_limit(half_width))
  end function

  !> Every sample carries its distance.
  pure function clsdf_band_full() result(band)
    type(clsdf_band) :: band
    band = clsdf_band_symmetric(clsdf_infinity())
  end function

  !> -0.0 inside and +0.0 outside.
  pure function clsdf_band_signs_only() result(band)
    type(clsdf_band) :: band
    band = clsdf_band(0, 0, 1)
  end function

  !> In the mesh's units; `voxel` is the grid's smallest spacing, `extent` the longest side of the mesh's box.
  function clsdf_length_resolve(length, voxel, extent, stat, errmsg) result(resolved)
    type(clsdf_length), intent(in) :: length
    real(c_double), intent(in) :: voxel, extent
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double) :: resolved
    call clsdf_finish(c_length_resolve(length, voxel, extent, resolved), stat, errmsg)
  end function

  pure function clsdf_grid_for_c(grid) result(c)
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_c_grid) :: c
    c = clsdf_c_grid(grid%origin, grid%spacing, grid%size, grid%first - 1)
  end function

  subroutine take_grid(c, grid)
    type(clsdf_c_grid), intent(in) :: c
    class(clsdf_grid), intent(inout) :: grid
    grid%origin = c%origin
    grid%spacing = c%spacing
    grid%size = c%size
    grid%first = c%first + 1
  end subroutine

  !> A grid around a mesh with `resolution` samples on the longest side. The margin is the band's outside half width; 5%
  !> of the longest side if it is infinite.
  subroutine grid_around_mesh(self, mesh, resolution, band, stat, errmsg)
    class(clsdf_grid), intent(inout) :: self
    type(clsdf_mesh), intent(in) :: mesh
    integer, intent(in) :: resolution
    type(clsdf_band), intent(in) :: band
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_grid) :: c
    integer(c_int32_t) :: status
    status = c_grid_around_mesh(mesh%handle, int(resolution, c_int64_t), band, c)
    if (status == CLSDF_OK) call take_grid(c, self)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> A grid around a box. Either `resolution`, the samples on the longest side, margin included (256), or `spacing`.
  subroutine grid_around_box(self, box, resolution, spacing, margin, cubic, cell_centred, stat, errmsg)
    class(clsdf_grid), intent(inout) :: self
    type(clsdf_box), intent(in) :: box
    integer, intent(in), optional :: resolution
    real(c_double), intent(in), optional :: spacing(3)
    type(clsdf_length), intent(in), optional :: margin  !< 5% of the longest side
    logical, intent(in), optional :: cubic, cell_centred
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_grid_options) :: options
    type(clsdf_c_grid) :: c
    integer(c_int32_t) :: status
    options%struct_size = c_sizeof(options)
    if (present(resolution)) options%resolution = resolution
    if (present(spacing)) options%spacing = spacing
    if (present(margin)) options%margin = margin
    if (present(cubic)) options%cubic = merge(1, 0, cubic)
    if (present(cell_centred)) options%cell_centred = merge(1, 0, cell_centred)
    status = c_grid_around_box(box, options, c)
    if (status == CLSDF_OK) call take_grid(c, self)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The grid from one corner of a box to the other: `samples` on each axis, both ends included, or `cells`, with samples
  !> at their corners or, with cell_centred, at their centres. The first sample is box%lower exactly, the spacing is rounded
  !> once. A slice: an axis on which both corners are equal has one sample, and the least of the other spacings.
  subroutine grid_between(self, box, samples, cells, cell_centred, stat, errmsg)
    class(clsdf_grid), intent(inout) :: self
    type(clsdf_box), intent(in) :: box
    integer, intent(in), optional :: samples(3), cells(3)
    logical, intent(in), optional :: cell_centred
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_grid_division) :: division
    type(clsdf_c_grid) :: c
    integer(c_int32_t) :: status
    division%struct_size = c_sizeof(division)
    if (present(samples)) division%samples = samples
    if (present(cells)) division%cells = cells
    if (present(cell_centred)) division%cell_centred = merge(1, 0, cell_centred)
    status = c_grid_between(box, division, c)
    if (status == CLSDF_OK) call take_grid(c, self)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The upper bounds of an array for the grid, whose lower bounds are `first`.
  pure function grid_last(self) result(last)
    class(clsdf_grid), intent(in) :: self
    integer(c_int64_t) :: last(3)
    last = self%first + self%size - 1
  end function

  !> The block from sample first(3) of the lattice on; must be inside this grid.
  function grid_part(self, first, size, stat, errmsg) result(part)
    class(clsdf_grid), intent(in) :: self
    integer(c_int64_t), intent(in) :: first(3), size(3)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_grid) :: part
    type(clsdf_c_grid) :: c
    call clsdf_finish(c_grid_part(c_of(self), first - self%first, size, c), stat, errmsg)
    call take_grid(c, part)
  end function

  function grid_part_4(self, first, size, stat, errmsg) result(part)
    class(clsdf_grid), intent(in) :: self
    integer(c_int32_t), intent(in) :: first(3), size(3)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_grid) :: part
    part = self%part(int(first, c_int64_t), int(size, c_int64_t), stat, errmsg)
  end function

  !> Any block of this lattice.
  function grid_block(self, first, size, stat, errmsg) result(block)
    class(clsdf_grid), intent(in) :: self
    integer(c_int64_t), intent(in) :: first(3), size(3)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_grid) :: block
    type(clsdf_c_grid) :: c
    call clsdf_finish(c_grid_block(c_of(self), first - 1, size, c), stat, errmsg)
    call take_grid(c, block)
  end function

  function grid_block_4(self, first, size, stat, errmsg) result(block)
    class(clsdf_grid), intent(in) :: self
    integer(c_int32_t), intent(in) :: first(3), size(3)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_grid) :: block
    block = self%block(int(first, c_int64_t), int(size, c_int64_t), stat, errmsg)
  end function

  !> So many samples more on every side; fewer if negative.
  function grid_grown(self, samples, stat, errmsg) result(grown)
    class(clsdf_grid), intent(in) :: self
    integer, intent(in) :: samples
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_grid) :: grown
    type(clsdf_c_grid) :: c
    call clsdf_finish(c_grid_grown(c_of(self), int(samples, c_int64_t), c), stat, errmsg)
    call take_grid(c, grown)
  end function

  !> A lattice `ratio` times as fine, from the first sample to the last: samples at nodes.
  function grid_refined(self, ratio, stat, errmsg) result(refined)
    class(clsdf_grid), intent(in) :: self
    integer, intent(in) :: ratio
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_grid) :: refined
    type(clsdf_c_grid) :: c
    call clsdf_finish(c_grid_refined(c_of(self), int(ratio, c_int64_t), c), stat, errmsg)
    call take_grid(c, refined)
  end function

  !> The same for samples at centres of cells: each cell becomes ratio**3 cells.
  function grid_refined_cells(self, ratio, stat, errmsg) result(refined)
    class(clsdf_grid), intent(in) :: self
    integer, intent(in) :: ratio
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_grid) :: refined
    type(clsdf_c_grid) :: c
    call clsdf_finish(c_grid_refined_cells(c_of(self), int(ratio, c_int64_t), c), stat, errmsg)
    call take_grid(c, refined)
  end function

  !> The bricks of sparse fields that overlap the grid, as a block of the lattice.
  function grid_in_whole_bricks(self, stat, errmsg) result(bricks)
    class(clsdf_grid), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_grid) :: bricks
    type(clsdf_c_grid) :: c
    call clsdf_finish(c_grid_in_whole_bricks(c_of(self), c), stat, errmsg)
    call take_grid(c, bricks)
  end function

  !> Shifted by half a voxel on every axis.
  function grid_cell_centred(self, stat, errmsg) result(centred)
    class(clsdf_grid), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_grid) :: centred
    type(clsdf_c_grid) :: c
    call clsdf_finish(c_grid_cell_centred(c_of(self), c), stat, errmsg)
    call take_grid(c, centred)
  end function

  !> Of sample (i, j, k) of the lattice: of phi(i, j, k) with the lower bounds `first`.
  function grid_position(self, i, j, k, stat, errmsg) result(position)
    class(clsdf_grid), intent(in) :: self
    integer, intent(in) :: i, j, k
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double) :: position(3)
    integer(c_int64_t) :: from(3)
    from = int([i, j, k], c_int64_t) - self%first
    call clsdf_finish(c_grid_position(c_of(self), from(1), from(2), from(3), position), stat, errmsg)
  end function

  !> From the first sample to the last.
  function grid_box(self, stat, errmsg) result(box)
    class(clsdf_grid), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_box) :: box
    call clsdf_finish(c_grid_box(c_of(self), box), stat, errmsg)
  end function

  !> The smallest spacing.
  function grid_voxel(self, stat, errmsg) result(voxel)
    class(clsdf_grid), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double) :: voxel
    call clsdf_finish(c_grid_voxel(c_of(self), voxel), stat, errmsg)
  end function

  function grid_sample_count(self, stat, errmsg) result(count)
    class(clsdf_grid), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: count
    call clsdf_finish(c_grid_sample_count(c_of(self), count), stat, errmsg)
  end function

  subroutine grid_validate(self, stat, errmsg)
    class(clsdf_grid), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_grid_validate(c_of(self)), stat, errmsg)
  end subroutine

  function c_of(grid) result(c)
    class(clsdf_grid), intent(in) :: grid
    type(clsdf_c_grid) :: c
    c = clsdf_c_grid(grid%origin, grid%spacing, grid%size, grid%first - 1)
  end function

  !> The slabs of a field on a device that sets no closer limit.
  subroutine clsdf_slabs_of(grid, slabs, stat, errmsg)
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_grid), allocatable, intent(out) :: slabs(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_grid), allocatable :: c(:)
    integer(c_int64_t) :: count, found
    integer(c_int32_t) :: status
    integer :: i
    allocate (c(0))
    status = c_slabs_of(c_of(grid), c, 0_c_int64_t, count)
    if (status == CLSDF_OK) then
      deallocate (c)
      allocate (c(count), slabs(count))
      status = c_slabs_of(c_of(grid), c, count, found)
      do i = 1, size(slabs)
        call take_grid(c(i), slabs(i))
      end do
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! ---- Arrays: where they lie, without a copy ----

  ! REPEATED FOR rank=2 | rank=3 | rank=4 | rank=5 |
  !     r8 | r8 rank=2 | r8 rank=3 | r8 rank=4 | r8 rank=5 |
  !     i4 | i4 rank=2 | i4 rank=3 | i4 rank=4 | i8 rank=2 | i1 | i1 rank=3 | i1 rank=4

  function array_r4_1(x) result(array)
    real(c_float), intent(in), target :: x(:)
    type(clsdf_array) :: array
    integer :: k(1)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_FLOAT32, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1)), [c_loc(x(k(1)))])
  end function

  ! REPEATED BY repeat.py

  function array_r4_2(x) result(array)
    real(c_float), intent(in), target :: x(:, :)
    type(clsdf_array) :: array
    integer :: k(2)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_FLOAT32, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1)), &
        [c_loc(x(k(1), 1)), c_loc(x(1, k(2)))])
  end function

  function array_r4_3(x) result(array)
    real(c_float), intent(in), target :: x(:, :, :)
    type(clsdf_array) :: array
    integer :: k(3)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_FLOAT32, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1, 1)), &
        [c_loc(x(k(1), 1, 1)), c_loc(x(1, k(2), 1)), c_loc(x(1, 1, k(3)))])
  end function

  function array_r4_4(x) result(array)
    real(c_float), intent(in), target :: x(:, :, :, :)
    type(clsdf_array) :: array
    integer :: k(4)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_FLOAT32, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1, 1, 1)), &
        [c_loc(x(k(1), 1, 1, 1)), c_loc(x(1, k(2), 1, 1)), c_loc(x(1, 1, k(3), 1)), &
        c_loc(x(1, 1, 1, k(4)))])
  end function

  function array_r4_5(x) result(array)
    real(c_float), intent(in), target :: x(:, :, :, :, :)
    type(clsdf_array) :: array
    integer :: k(5)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_FLOAT32, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1, 1, 1, 1)), &
        [c_loc(x(k(1), 1, 1, 1, 1)), c_loc(x(1, k(2), 1, 1, 1)), c_loc(x(1, 1, k(3), 1, 1)), &
        c_loc(x(1, 1, 1, k(4), 1)), c_loc(x(1, 1, 1, 1, k(5)))])
  end function

  function array_r8_1(x) result(array)
    real(c_double), intent(in), target :: x(:)
    type(clsdf_array) :: array
    integer :: k(1)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_FLOAT64, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1)), [c_loc(x(k(1)))])
  end function

  function array_r8_2(x) result(array)
    real(c_double), intent(in), target :: x(:, :)
    type(clsdf_array) :: array
    integer :: k(2)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_FLOAT64, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1)), &
        [c_loc(x(k(1), 1)), c_loc(x(1, k(2)))])
  end function

  function array_r8_3(x) result(array)
    real(c_double), intent(in), target :: x(:, :, :)
    type(clsdf_array) :: array
    integer :: k(3)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_FLOAT64, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1, 1)), &
        [c_loc(x(k(1), 1, 1)), c_loc(x(1, k(2), 1)), c_loc(x(1, 1, k(3)))])
  end function

  function array_r8_4(x) result(array)
    real(c_double), intent(in), target :: x(:, :, :, :)
    type(clsdf_array) :: array
    integer :: k(4)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_FLOAT64, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1, 1, 1)), &
        [c_loc(x(k(1), 1, 1, 1)), c_loc(x(1, k(2), 1, 1)), c_loc(x(1, 1, k(3), 1)), &
        c_loc(x(1, 1, 1, k(4)))])
  end function

  function array_r8_5(x) result(array)
    real(c_double), intent(in), target :: x(:, :, :, :, :)
    type(clsdf_array) :: array
    integer :: k(5)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_FLOAT64, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1, 1, 1, 1)), &
        [c_loc(x(k(1), 1, 1, 1, 1)), c_loc(x(1, k(2), 1, 1, 1)), c_loc(x(1, 1, k(3), 1, 1)), &
        c_loc(x(1, 1, 1, k(4), 1)), c_loc(x(1, 1, 1, 1, k(5)))])
  end function

  function array_i4_1(x) result(array)
    integer(c_int32_t), intent(in), target :: x(:)
    type(clsdf_array) :: array
    integer :: k(1)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_INT32, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1)), [c_loc(x(k(1)))])
  end function

  function array_i4_2(x) result(array)
    integer(c_int32_t), intent(in), target :: x(:, :)
    type(clsdf_array) :: array
    integer :: k(2)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_INT32, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1)), &
        [c_loc(x(k(1), 1)), c_loc(x(1, k(2)))])
  end function

  function array_i4_3(x) result(array)
    integer(c_int32_t), intent(in), target :: x(:, :, :)
    type(clsdf_array) :: array
    integer :: k(3)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_INT32, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1, 1)), &
        [c_loc(x(k(1), 1, 1)), c_loc(x(1, k(2), 1)), c_loc(x(1, 1, k(3)))])
  end function

  function array_i4_4(x) result(array)
    integer(c_int32_t), intent(in), target :: x(:, :, :, :)
    type(clsdf_array) :: array
    integer :: k(4)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_INT32, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1, 1, 1)), &
        [c_loc(x(k(1), 1, 1, 1)), c_loc(x(1, k(2), 1, 1)), c_loc(x(1, 1, k(3), 1)), &
        c_loc(x(1, 1, 1, k(4)))])
  end function

  function array_i8_2(x) result(array)
    integer(c_int64_t), intent(in), target :: x(:, :)
    type(clsdf_array) :: array
    integer :: k(2)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_INT64, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1)), &
        [c_loc(x(k(1), 1)), c_loc(x(1, k(2)))])
  end function

  function array_i1_1(x) result(array)
    integer(c_int8_t), intent(in), target :: x(:)
    type(clsdf_array) :: array
    integer :: k(1)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_UINT8, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1)), [c_loc(x(k(1)))])
  end function

  function array_i1_3(x) result(array)
    integer(c_int8_t), intent(in), target :: x(:, :, :)
    type(clsdf_array) :: array
    integer :: k(3)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_UINT8, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1, 1)), &
        [c_loc(x(k(1), 1, 1)), c_loc(x(1, k(2), 1)), c_loc(x(1, 1, k(3)))])
  end function

  function array_i1_4(x) result(array)
    integer(c_int8_t), intent(in), target :: x(:, :, :, :)
    type(clsdf_array) :: array
    integer :: k(4)
    k = int(min(2_c_int64_t, shape(x, c_int64_t)))
    call describe(array, CLSDF_UINT8, shape(x, c_int64_t))
    if (any(k == 0)) return
    call place(array, c_loc(x(1, 1, 1, 1)), &
        [c_loc(x(k(1), 1, 1, 1)), c_loc(x(1, k(2), 1, 1)), c_loc(x(1, 1, k(3), 1)), &
        c_loc(x(1, 1, 1, k(4)))])
  end function

  ! END

  !> Numbers in a buffer of the device. Bytes, as in C: of the first number, from a sample to the next along each axis,
  !> from a component to the next, from a block to the next. `count`: of items, which points need.
  !> The same array of an output, in memory that is pinned: see clsdf_array of C. In clsdf_target(CLSDF_DISTANCE,
  !> clsdf_pinned(clsdf_array(x))).
  function clsdf_pinned(array) result(pinned)
    type(clsdf_array), intent(in) :: array
    type(clsdf_array) :: pinned
    pinned = array
    pinned%pinned = 1
  end function

  function array_of_buffer(buffer, type, count, offset, strides, component_stride, block_stride) result(array)
    type(c_ptr), intent(in) :: buffer
    integer(c_int32_t), intent(in) :: type
    integer(c_int64_t), intent(in), optional :: count, offset, strides(3), component_stride, block_stride
    type(clsdf_array) :: array
    array%device = buffer
    array%type = type
    if (present(count)) array%count = count
    if (present(offset)) array%offset = offset
    if (present(strides)) array%strides(1:3) = strides
    if (present(component_stride)) array%component_stride = component_stride
    if (present(block_stride)) array%block_stride = block_stride
  end function

  subroutine describe(array, type, shape)
    type(clsdf_array), intent(inout) :: array
    integer(c_int32_t), intent(in) :: type
    integer(c_int64_t), intent(in) :: shape(:)
    array%type = type
    array%rank = size(shape)
    array%shape(1:size(shape)) = shape
  end subroutine

  !> Strides from the addresses of neighbouring elements. An axis of one element gets any.
  subroutine place(array, first, neighbours)
    type(clsdf_array), intent(inout) :: array
    type(c_ptr), intent(in) :: first, neighbours(:)
    integer(c_int64_t) :: packed
    integer :: i
    array%host = first
    packed = bytes_of(array%type)
    do i = 1, size(neighbours)
      array%strides(i) = address(neighbours(i)) - address(first)
      if (array%shape(i) == 1) array%strides(i) = packed
      packed = array%strides(i)*array%shape(i)
    end do
  end subroutine

  pure function bytes_of(type) result(bytes)
    integer(c_int32_t), intent(in) :: type
    integer(c_int64_t) :: bytes
    integer(c_int64_t), parameter :: of_types(7) = [4, 8, 4, 8, 4, 8, 1]
    bytes = of_types(type)
  end function

  pure function address(pointer) result(number)
    type(c_ptr), intent(in) :: pointer
    integer(c_intptr_t) :: number
    number = transfer(pointer, number)
  end function

  !> An array of items as C describes it. `items`: their number along each axis; the first `axes` of them have strides of
  !> their own, the next one is that of blocks. Components come first, or after the axes.
  subroutine for_c(array, what, components, items, axes, c, status)
    type(clsdf_array), intent(in) :: array
    character(*), intent(in) :: what
    integer(c_int64_t), intent(in) :: components, items(:)
    integer, intent(in) :: axes
    type(clsdf_c_array), intent(out) :: c
    integer(c_int32_t), intent(inout) :: status
    integer :: n, skipped
    integer :: rest(5)
    c%type = array%type
    if (c_associated(array%device)) then
      c%device = array%device
      c%offset = array%offset
      c%count = array%count
      c%strides = array%strides(1:3)
      c%component_stride = array%component_stride
      c%block_stride = array%block_stride
      return
    end if
    n = size(items)
    skipped = 0  ! the axis of components; 0: none
    if (components == 1) then
      if (array%rank /= n .or. any(array%shape(1:n) /= items)) skipped = -1
    else if (array%rank /= n + 1) then
      skipped = -1
    else if (array%shape(1) == components .and. all(array%shape(2:n + 1) == items)) then
      skipped = 1
    else if (array%shape(axes + 1) == components .and. all(array%shape(1:axes) == items(1:axes)) .and. &
        all(array%shape(axes + 2:n + 1) == items(axes + 1:))) then
      skipped = axes + 1
    else
      skipped = -1
    end if
    if (skipped < 0) then
      status = refused('the array of the '//what//' has the shape '//joined(array%shape(1:array%rank))//'; give it '// &
          shapes(components, items, axes))
      return
    end if
    c%pinned = array%pinned
    rest = [1, 2, 3, 4, 5]
    if (skipped > 0) rest(skipped:4) = rest(skipped + 1:5)
    c%host = array%host
    if (axes == 1) c%count = items(1)
    c%strides(1:axes) = array%strides(rest(1:axes))
    if (skipped > 0) c%component_stride = array%strides(skipped)
    if (n > axes) c%block_stride = array%strides(rest(axes + 1))
  end subroutine

  function shapes(components, items, axes) result(text)
    integer(c_int64_t), intent(in) :: components, items(:)
    integer, intent(in) :: axes
    character(:), allocatable :: text
    text = joined(items)
    if (components > 1) text = joined([components, items])//' or '//joined([items(1:axes), components, items(axes + 1:)])
  end function

  function joined(numbers) result(text)
    integer(c_int64_t), intent(in) :: numbers(:)
    character(:), allocatable :: text
    character(24) :: number
    integer :: i
    text = '('
    do i = 1, size(numbers)
      write (number, '(i0)') numbers(i)
      if (i > 1) text = text//', '
      text = text//trim(number)
    end do
    text = text//')'
  end function

  !> Targets as C has them, whose arrays fit the items.
  subroutine clsdf_targets_of_samples(targets, items, axes, c, status)
    type(clsdf_target), intent(in) :: targets(:)
    integer(c_int64_t), intent(in) :: items(:)
    integer, intent(in) :: axes
    type(clsdf_c_target), intent(out) :: c(:)
    integer(c_int32_t), intent(inout) :: status
    type(c_output_info) :: info
    integer :: i
    do i = 1, size(targets)
      info = c_output_info(c_sizeof(info) + 1)
      if (status == CLSDF_OK) status = c_output_describe(targets(i)%output, info)
      if (status /= CLSDF_OK) return
      c(i)%output = targets(i)%output
      call for_c(targets(i)%array, clsdf_text(info%name), info%components, items, axes, c(i)%array, status)
    end do
  end subroutine

  ! REPEATED FOR rank=2 | rank=3 | rank=4 | rank=5 |
  !     r8 | r8 rank=2 | r8 rank=3 | r8 rank=4 | r8 rank=5 |
  !     i4 | i4 rank=3 | i4 rank=4 | i1 | i1 rank=3 | i1 rank=4

  function target_r4_1(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    real(c_float), intent(in), target :: x(:)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  ! REPEATED BY repeat.py

  function target_r4_2(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    real(c_float), intent(in), target :: x(:, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_r4_3(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    real(c_float), intent(in), target :: x(:, :, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_r4_4(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    real(c_float), intent(in), target :: x(:, :, :, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_r4_5(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    real(c_float), intent(in), target :: x(:, :, :, :, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_r8_1(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    real(c_double), intent(in), target :: x(:)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_r8_2(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    real(c_double), intent(in), target :: x(:, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_r8_3(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    real(c_double), intent(in), target :: x(:, :, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_r8_4(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    real(c_double), intent(in), target :: x(:, :, :, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_r8_5(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    real(c_double), intent(in), target :: x(:, :, :, :, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_i4_1(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    integer(c_int32_t), intent(in), target :: x(:)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_i4_3(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    integer(c_int32_t), intent(in), target :: x(:, :, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_i4_4(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    integer(c_int32_t), intent(in), target :: x(:, :, :, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_i1_1(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    integer(c_int8_t), intent(in), target :: x(:)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_i1_3(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    integer(c_int8_t), intent(in), target :: x(:, :, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  function target_i1_4(output, x) result(target)
    integer(c_int32_t), intent(in) :: output
    integer(c_int8_t), intent(in), target :: x(:, :, :, :)
    type(clsdf_target) :: target
    target = target_of_array(output, clsdf_array(x))
  end function

  ! END

  function target_of_array(output, array) result(target)
    integer(c_int32_t), intent(in) :: output
    type(clsdf_array), intent(in) :: array
    type(clsdf_target) :: target
    target%output = output
    target%array = array
  end function

  function target_of_buffer(output, buffer, type, offset, strides, component_stride, block_stride) result(target)
    integer(c_int32_t), intent(in) :: output
    type(c_ptr), intent(in) :: buffer
    integer(c_int32_t), intent(in) :: type
    integer(c_int64_t), intent(in), optional :: offset, strides(3), component_stride, block_stride
    type(clsdf_target) :: target
    target%output = output
    target%array = array_of_buffer(buffer, type, offset=offset, strides=strides, component_stride=component_stride, &
        block_stride=block_stride)
  end function

  ! ---- Calls: options, statistics, slabs ----

  !> The options of a call for C, null for none. `given` lives as long as the call.
  function options_for_c(given, options) result(pointer)
    type(caller), intent(inout), target :: given
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(c_ptr) :: pointer
    pointer = c_null_ptr
    if (.not. present(options)) return
    given%options => options
    given%c%struct_size = c_sizeof(given%c)
    given%c%user = c_loc(given)
    if (associated(options%progress)) given%c%progress = c_funloc(on_progress)
    if (associated(options%should_stop)) given%c%should_stop = c_funloc(on_stop)
    if (associated(options%log)) given%c%log = c_funloc(on_log)
    if (allocated(options%wait_list)) then
      given%c%wait_count = size(options%wait_list)
      if (size(options%wait_list) > 0) given%c%wait_list = c_loc(options%wait_list(1))
    end if
    given%c%refuse_unusable_points = merge(1_c_int32_t, 0_c_int32_t, options%refuse_unusable_points)
    pointer = c_loc(given%c)
  end function

  ! name="": no global symbols. A program may have functions of these names.

  function on_progress(user, progress) bind(C, name="") result(status)
    type(c_ptr), value :: user
    type(clsdf_progress), intent(in) :: progress
    integer(c_int32_t) :: status
    type(caller), pointer :: given
    call c_f_pointer(user, given)
    status = CLSDF_OK
    call given%options%progress(progress, status)
  end function

  function on_stop(user) bind(C, name="") result(status)
    type(c_ptr), value :: user
    integer(c_int32_t) :: status
    type(caller), pointer :: given
    call c_f_pointer(user, given)
    status = CLSDF_OK
    call given%options%should_stop(status)
  end function

  function on_log(user, message) bind(C, name="") result(status)
    type(c_ptr), value :: user, message
    integer(c_int32_t) :: status
    type(caller), pointer :: given
    call c_f_pointer(user, given)
    status = CLSDF_OK
    call given%options%log(clsdf_text(message), status)
  end function

  function on_slab(user, part, values, count) bind(C, name="") result(status)
    type(c_ptr), value :: user, values
    type(clsdf_c_grid), intent(in) :: part
    integer(c_int64_t), value :: count
    integer(c_int32_t) :: status
    type(slab_taker), pointer :: taker
    type(clsdf_slab) :: slab
    call c_f_pointer(user, taker)
    call take_grid(part, slab%part)
    slab%values = values
    slab%count = count
    slab%index_base = taker%index_base
    status = CLSDF_OK
    call taker%sink%take(slab, status)
  end function

  function on_link_slab(user, part, arrays, count) bind(C, name="") result(status)
    type(c_ptr), value :: user
    type(clsdf_c_grid), intent(in) :: part
    type(c_link_arrays), intent(in) :: arrays
    integer(c_int64_t), value :: count
    integer(c_int32_t) :: status
    type(link_taker), pointer :: taker
    type(clsdf_grid) :: of_slab
    type(clsdf_links) :: links
    integer(c_int32_t), pointer :: samples(:, :), numbers(:)
    real(c_double), pointer :: q(:)
    integer(c_int8_t), pointer :: bytes(:), inside(:, :, :)
    call c_f_pointer(user, taker)
    call take_grid(part, of_slab)
    allocate (links%samples(3, count), links%directions(count), links%q(count), links%triangles(count), &
        links%counts(count), links%flags(count))
    if (count > 0) then
      call c_f_pointer(arrays%samples, samples, [3_c_int64_t, count])
      links%samples = samples + 1
      call c_f_pointer(arrays%directions, bytes, [count])
      links%directions = bytes
      call c_f_pointer(arrays%q, q, [count])
      links%q = q
      call c_f_pointer(arrays%triangles, numbers, [count])
      links%triangles = numbers
      call c_f_pointer(arrays%counts, numbers, [count])
      links%counts = numbers
      call c_f_pointer(arrays%flags, bytes, [count])
      links%flags = bytes
    end if
    call c_f_pointer(arrays%inside, inside, of_slab%size)
    links%inside = inside
    status = CLSDF_OK
    call taker%sink%take_links(of_slab, links, status)
  end function

  function on_sparse_slab(user, slab) bind(C, name="") result(status)
    type(c_ptr), value :: user
    type(clsdf_c_sparse_slab), intent(in) :: slab
    integer(c_int32_t) :: status
    type(sparse_taker), pointer :: taker
    type(clsdf_sparse_slab) :: layers
    call c_f_pointer(user, taker)
    call take_sparse_slab(slab, taker%index_base, layers)
    status = CLSDF_OK
    call taker%sink%take_sparse(layers, status)
  end function

  subroutine take_sparse_slab(c, index_base, slab)
    type(clsdf_c_sparse_slab), intent(in) :: c
    integer(c_int32_t), intent(in) :: index_base
    type(clsdf_sparse_slab), intent(out) :: slab
    call take_grid(c%part, slab%part)
    slab%brick_count = c%brick_count
    slab%run_count = c%run_count
    slab%index_base = index_base
    slab%c = c
  end subroutine

  function statistics_for_c(statistics) result(pointer)
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    type(c_ptr) :: pointer
    pointer = c_null_ptr
    if (.not. present(statistics)) return
    statistics%struct_size = c_sizeof(statistics) + 1  ! calls fill it
    pointer = c_loc(statistics)
  end function

  ! ---- Devices ----

  !> All devices of all platforms, also those that cannot be used.
  subroutine clsdf_devices_list(devices, stat, errmsg)
    type(clsdf_device_info), allocatable, intent(out) :: devices(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ptr) :: list
    type(c_device_info) :: c
    integer(c_int32_t) :: status
    integer :: i
    status = c_devices_list(list)
    allocate (devices(c_devices_count(list)))
    do i = 1, size(devices)
      c = c_device_info(c_sizeof(c) + 1)
      if (status == CLSDF_OK) status = c_devices_describe(list, int(i - 1, c_int64_t), c)
      if (status == CLSDF_OK) call take_info(c, devices(i))
    end do
    call c_devices_release(list)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine take_info(c, info)
    type(c_device_info), intent(in) :: c
    type(clsdf_device_info), intent(out) :: info
    info%index = c%index
    info%id = c%id
    info%name = clsdf_text(c%name)
    info%platform = clsdf_text(c%platform)
    info%version = clsdf_text(c%version)
    info%driver = clsdf_text(c%driver)
    info%why_not = clsdf_text(c%why_not)
    info%compute_units = c%compute_units
    info%clock_megahertz = c%clock_megahertz
    info%memory = c%memory
    info%largest_allocation = c%largest_allocation
    info%float_width = c%float_width
    info%kind = c%kind
    info%fp64 = c%fp64 == 1
    info%atomics64 = c%atomics64 == 1
    info%source = c%source
    info%driver_file = clsdf_text(c%driver_file)
    info%only_if_named = clsdf_text(c%only_if_named)
  end subroutine

  !> device%select() with the environment variable CLSDF_DEVICE if it is set and not empty, else the strongest.
  subroutine device_automatic(self, stat, errmsg)
    class(clsdf_device), intent(inout) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%release()
    call clsdf_finish(c_device_automatic(self%handle), stat, errmsg)
  end subroutine

  !> The strongest GPU, else the strongest other device.
  subroutine device_strongest(self, stat, errmsg)
    class(clsdf_device), intent(inout) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%release()
    call clsdf_finish(c_device_strongest(self%handle), stat, errmsg)
  end subroutine

  !> A whole number is an index in the list, from 0. Any other text is a part of the name of exactly one usable device.
  subroutine device_select(self, index_or_part, stat, errmsg)
    class(clsdf_device), intent(inout) :: self
    character(*), intent(in) :: index_or_part
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%release()
    call clsdf_finish(c_device_select(trim(index_or_part)//c_null_char, self%handle), stat, errmsg)
  end subroutine

  !> The share of a process: `rank` of the `ranks` processes on this machine, 0 <= rank < ranks, as MPI counts.
  subroutine device_of_rank(self, rank, ranks, stat, errmsg)
    class(clsdf_device), intent(inout) :: self
    integer, intent(in) :: rank, ranks
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%release()
    call clsdf_finish(c_device_of_rank(int(rank, c_int64_t), int(ranks, c_int64_t), self%handle), stat, errmsg)
  end subroutine

  !> Retains the caller's cl_context, cl_device_id and cl_command_queue.
  subroutine device_from_handles(self, context, id, queue, stat, errmsg)
    class(clsdf_device), intent(inout) :: self
    type(c_ptr), intent(in) :: context, id, queue
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%release()
    call clsdf_finish(c_device_from_handles(context, id, queue, self%handle), stat, errmsg)
  end subroutine

  !> The same device with limits: compute units to use, and bytes of the buffers of one transform and its plans; 0: all.
  subroutine device_limited(self, limited, compute_units, memory, stat, errmsg)
    class(clsdf_device), intent(in) :: self
    type(clsdf_device), intent(inout) :: limited
    integer(c_int64_t), intent(in), optional :: compute_units, memory
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_device_limits) :: limits
    type(c_ptr) :: handle
    integer(c_int32_t) :: status
    limits%struct_size = c_sizeof(limits)
    if (present(compute_units)) limits%compute_units = compute_units
    if (present(memory)) limits%memory = memory
    status = c_device_limited(self%handle, limits, handle)
    call limited%release()
    limited%handle = handle
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine device_describe(self, info, stat, errmsg)
    class(clsdf_device), intent(in) :: self
    type(clsdf_device_info), intent(out) :: info
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_device_info) :: c
    integer(c_int32_t) :: status
    c%struct_size = c_sizeof(c) + 1  ! calls fill it
    status = c_device_describe(self%handle, c)
    if (status == CLSDF_OK) call take_info(c, info)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The cl_context, cl_device_id and cl_command_queue, which belong to the device.
  subroutine device_handles(self, context, id, queue, stat, errmsg)
    class(clsdf_device), intent(in) :: self
    type(c_ptr), intent(out) :: context, id, queue
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_device_handles(self%handle, context, id, queue), stat, errmsg)
  end subroutine

  !> Keeps records of passed tests in the folder; "": none.
  subroutine device_keep_records(self, folder, stat, errmsg)
    class(clsdf_device), intent(in) :: self
    character(*), intent(in) :: folder
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_device_keep_records(self%handle, trim(folder)//c_null_char), stat, errmsg)
  end subroutine

  !> Takes compiled programs from a folder in which nobody else can write; "": none.
  subroutine device_read_programs(self, folder, stat, errmsg)
    class(clsdf_device), intent(in) :: self
    character(*), intent(in) :: folder
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_device_read_programs(self%handle, trim(folder)//c_null_char), stat, errmsg)
  end subroutine

  !> Writes programs that are compiled from now on to the folder, too; "": none.
  subroutine device_write_programs(self, folder, stat, errmsg)
    class(clsdf_device), intent(in) :: self
    character(*), intent(in) :: folder
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_device_write_programs(self%handle, trim(folder)//c_null_char), stat, errmsg)
  end subroutine

  subroutine device_forget_records(self, stat, errmsg)
    class(clsdf_device), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_device_forget_records(self%handle), stat, errmsg)
  end subroutine

  !> Gives back what the device keeps for later calls, beside what transforms and plans hold: arrays of the host, at
  !> most 32 MiB; and, of a device with memory of its own, memory of the device that no transform uses, at most 512 MiB
  !> and 1/32 of its memory, and 40 MiB of pinned memory of the host. bytes: how many.
  subroutine device_release_memory(self, bytes, stat, errmsg)
    class(clsdf_device), intent(in) :: self
    integer(c_int64_t), intent(out), optional :: bytes
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: released
    call clsdf_finish(c_device_release_memory(self%handle, released), stat, errmsg)
    if (present(bytes)) bytes = released
  end subroutine

  !> A cl_mem of `bytes` bytes, of the device's context, that is memory of another interface: of CUDA for instance,
  !> exported as a POSIX file descriptor (cuMemExportToShareableHandle). On success the driver owns the descriptor, and
  !> you release the cl_mem; after an error you still own the descriptor. Commands may use the cl_mem only between
  !> clEnqueueAcquireExternalMemObjectsKHR and clEnqueueReleaseExternalMemObjectsKHR, which you enqueue.
  subroutine device_import_memory(self, descriptor, bytes, memory, stat, errmsg)
    class(clsdf_device), intent(in) :: self
    integer(c_int32_t), intent(in) :: descriptor
    integer(c_int64_t), intent(in) :: bytes
    type(c_ptr), intent(out) :: memory
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_device_import_memory(self%handle, descriptor, bytes, memory), stat, errmsg)
  end subroutine

  !> The folder of keep_records().
  subroutine device_record_folder(self, folder, stat, errmsg)
    class(clsdf_device), intent(in) :: self
    character(:), allocatable, intent(out) :: folder
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    character(kind=c_char), allocatable, target :: text(:)
    integer(c_int64_t) :: length, written
    integer(c_int32_t) :: status
    status = c_device_record_folder(self%handle, c_null_ptr, 0_c_int64_t, length)
    if (status == CLSDF_OK) then
      allocate (text(length + 1))
      status = c_device_record_folder(self%handle, c_loc(text), length + 1, written)
      folder = clsdf_text(c_loc(text))
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The folder that clsdf's command uses; "" if none is known.
  subroutine clsdf_default_record_folder(folder, stat, errmsg)
    character(:), allocatable, intent(out) :: folder
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    character(kind=c_char), allocatable, target :: text(:)
    integer(c_int64_t) :: length, written
    integer(c_int32_t) :: status
    status = c_default_record_folder(c_null_ptr, 0_c_int64_t, length)
    if (status == CLSDF_OK) then
      allocate (text(length + 1))
      status = c_default_record_folder(c_loc(text), length + 1, written)
      folder = clsdf_text(c_loc(text))
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The loops of the library on the host have at most `count` threads, the calling one included, while `self` lives.
  subroutine limit_set(self, count, stat, errmsg)
    class(clsdf_thread_limit), intent(inout) :: self
    integer, intent(in) :: count
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%release()
    call clsdf_finish(c_limit_threads(int(count, c_int64_t), self%handle), stat, errmsg)
  end subroutine

  function clsdf_thread_count() result(count)
    integer(c_int64_t) :: count
    count = c_thread_count()
  end function

  ! ---- Meshes ----

  !> A checked copy of arrays of the host: vertices(3, n), and triangles(3, m) from 1.
  subroutine mesh_create(self, vertices, triangles, name, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    type(clsdf_array), intent(in) :: vertices, triangles
    character(*), intent(in), optional :: name
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_mesh_arrays) :: c
    character(:), allocatable, target :: text
    type(c_ptr) :: handle
    integer(c_int32_t) :: status
    handle = c_null_ptr
    call mesh_for_c(vertices, triangles, name, c, text, status)
    if (status == CLSDF_OK) status = c_mesh_create(c, handle)
    call self%release()  ! not before: the arrays may be its own
    self%handle = handle
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> `text` keeps the name for the call.
  subroutine mesh_for_c(vertices, triangles, name, c, text, status)
    type(clsdf_array), intent(in) :: vertices, triangles
    character(*), intent(in), optional :: name
    type(c_mesh_arrays), intent(inout) :: c
    character(:), allocatable, target, intent(inout) :: text
    integer(c_int32_t), intent(out) :: status
    status = CLSDF_OK
    c%struct_size = c_sizeof(c)
    call rows_for_c(vertices, 'vertices', c%vertices, status)
    if (status == CLSDF_OK) call rows_for_c(triangles, 'triangles', c%triangles, status)
    ! Only arrays of the host count from 1 in C.
    if (c_associated(triangles%device)) c%index_base = 0
    if (.not. present(name)) return
    text = trim(name)//c_null_char
    c%name = c_loc(text)
  end subroutine

  !> An array of triples.
  subroutine rows_for_c(array, what, c, status)
    type(clsdf_array), intent(in) :: array
    character(*), intent(in) :: what
    type(clsdf_c_array), intent(inout) :: c
    integer(c_int32_t), intent(inout) :: status
    integer(c_int64_t) :: count
    count = array%shape(2)
    if (array%shape(1) /= 3) count = array%shape(1)
    if (.not. c_associated(array%device) .and. (array%rank /= 2 .or. all(array%shape(1:2) /= 3))) then
      status = refused('the array of the '//what//' has the shape '//joined(array%shape(1:array%rank))// &
          '; give it (3, n) or (n, 3)')
      return
    end if
    call for_c(array, what, 3_c_int64_t, [count], 1, c, status)
  end subroutine

  ! REPEATED FOR i4=i8 c_int32_t=c_int64_t | r8 | r8 i4=i8 c_int32_t=c_int64_t

  subroutine mesh_create_r4_i4(self, vertices, triangles, name, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    real(c_float), intent(in), target :: vertices(:, :)
    integer(c_int32_t), intent(in), target :: triangles(:, :)
    character(*), intent(in), optional :: name
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%create(clsdf_array(vertices), clsdf_array(triangles), name, stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  subroutine mesh_create_r4_i8(self, vertices, triangles, name, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    real(c_float), intent(in), target :: vertices(:, :)
    integer(c_int64_t), intent(in), target :: triangles(:, :)
    character(*), intent(in), optional :: name
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%create(clsdf_array(vertices), clsdf_array(triangles), name, stat, errmsg)
  end subroutine

  subroutine mesh_create_r8_i4(self, vertices, triangles, name, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    real(c_double), intent(in), target :: vertices(:, :)
    integer(c_int32_t), intent(in), target :: triangles(:, :)
    character(*), intent(in), optional :: name
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%create(clsdf_array(vertices), clsdf_array(triangles), name, stat, errmsg)
  end subroutine

  subroutine mesh_create_r8_i8(self, vertices, triangles, name, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    real(c_double), intent(in), target :: vertices(:, :)
    integer(c_int64_t), intent(in), target :: triangles(:, :)
    character(*), intent(in), optional :: name
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%create(clsdf_array(vertices), clsdf_array(triangles), name, stat, errmsg)
  end subroutine

  ! END

  ! REPEATED FOR r8

  subroutine mesh_set_positions_r4(self, positions, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    real(c_float), intent(in), target :: positions(:, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%set_positions(clsdf_array(positions), stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  subroutine mesh_set_positions_r8(self, positions, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    real(c_double), intent(in), target :: positions(:, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%set_positions(clsdf_array(positions), stat, errmsg)
  end subroutine

  ! END

  !> A mesh made by code: "sphere0" to "sphere9", "torus", "knot", ...
  subroutine mesh_shape(self, name, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: status
    call self%release()
    status = c_mesh_shape(trim(name)//c_null_char, self%handle)
    if (status == CLSDF_OK) status = c_mesh_set_index_base(self%handle, 1_c_int32_t)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Reads .off, .obj, .stl or .ply; polygons become fans. The log of the options gets what was skipped or changed.
  subroutine mesh_read(self, path, scale, translate, stat, errmsg, options, up, rotate, group_by, skip_bad_facets)
    class(clsdf_mesh), intent(inout) :: self
    character(*), intent(in) :: path
    real(c_double), intent(in), optional :: scale, translate(3)  !< a position x becomes R (x * scale) + translate
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    class(clsdf_call_options), intent(inout), target, optional :: options
    character(*), intent(in), optional :: up        !< the axis of the file that points up, 'y': the mesh gets z up
    real(c_double), intent(in), optional :: rotate(3)  !< degrees about x, then y, then z, after `up`
    character(*), intent(in), optional :: group_by  !< a property of the faces of .ply files
    logical, intent(in), optional :: skip_bad_facets  !< leave out faces of a vertex that is not finite or does not exist
    call self%read([path], scale, translate, stat, errmsg, options, up, rotate, group_by, skip_bad_facets)
  end subroutine

  !> Reads files as one mesh: the vertices and the triangles of each follow those of the one before it. Each file is a
  !> group with the name of the file; a file with several groups has 'file/group'.
  subroutine mesh_read_files(self, paths, scale, translate, stat, errmsg, options, up, rotate, group_by, skip_bad_facets)
    class(clsdf_mesh), intent(inout) :: self
    character(*), intent(in) :: paths(:)
    real(c_double), intent(in), optional :: scale, translate(3)  !< a position x becomes R (x * scale) + translate
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    class(clsdf_call_options), intent(inout), target, optional :: options
    character(*), intent(in), optional :: up        !< the axis of the file that points up, 'y': the mesh gets z up
    real(c_double), intent(in), optional :: rotate(3)  !< degrees about x, then y, then z, after `up`
    character(*), intent(in), optional :: group_by  !< a property of the faces of .ply files
    logical, intent(in), optional :: skip_bad_facets  !< leave out faces of a vertex that is not finite or does not exist
    character(kind=c_char), target :: texts(len(paths) + 1, size(paths))
    type(c_ptr) :: pointers(size(paths))
    type(caller), target :: given
    character(:), allocatable, target :: up_text, group_text
    type(c_read_options) :: read
    integer(c_int32_t) :: status
    call self%release()
    call texts_for_c(paths, texts, pointers)
    read%struct_size = c_sizeof(read)
    if (present(scale)) read%scale = scale
    if (present(translate)) read%translate = translate
    if (present(skip_bad_facets)) read%skip_bad_facets = merge(1, 0, skip_bad_facets)
    if (present(rotate)) read%rotate = rotate
    if (present(up)) then
      up_text = trim(up)//c_null_char
      read%up = c_loc(up_text)
    end if
    if (present(group_by)) then
      group_text = trim(group_by)//c_null_char
      read%group_by = c_loc(group_text)
    end if
    if (present(options)) then
      given%options => options
      read%user = c_loc(given)
      if (associated(options%log)) read%log = c_funloc(on_log)
    end if
    status = c_mesh_read_files(pointers, size(paths, kind=c_int64_t), read, self%handle)
    if (status == CLSDF_OK) status = c_mesh_set_index_base(self%handle, 1_c_int32_t)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine texts_for_c(from, texts, pointers)
    character(*), intent(in) :: from(:)
    character(kind=c_char), intent(out), target :: texts(:, :)  !< (the longest text and one more, texts)
    type(c_ptr), intent(out) :: pointers(:)
    integer :: i, k
    do i = 1, size(from)
      do k = 1, len_trim(from(i))
        texts(k, i) = from(i)(k:k)
      end do
      texts(len_trim(from(i)) + 1, i) = c_null_char
      pointers(i) = c_loc(texts(1, i))
    end do
  end subroutine

  !> The mesh in which vertices of equal coordinates are one, with the same index base. tolerance: those that differ by
  !> at most so much on every axis are one, too; clusters longer than four tolerances are left apart. report: what became
  !> of the faces. warning: says so, with the remedy, if a wall that is thinner than the tolerance is flat; else "".
  subroutine mesh_weld(self, welded, tolerance, stat, errmsg, report, warning)
    class(clsdf_mesh), intent(in) :: self
    type(clsdf_mesh), intent(inout) :: welded
    real(c_double), intent(in), optional :: tolerance
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_weld_report), intent(out), optional :: report
    character(:), allocatable, intent(out), optional :: warning
    type(clsdf_weld_report) :: found
    character(kind=c_char), allocatable, target :: text(:)
    integer(c_int64_t) :: length, written
    type(c_ptr) :: handle
    integer(c_int32_t) :: status
    if (present(tolerance)) then
      status = c_mesh_weld_within(self%handle, tolerance, handle)
    else
      status = c_mesh_weld(self%handle, handle)
    end if
    if (status == CLSDF_OK .and. (present(report) .or. present(warning))) then
      found%struct_size = c_sizeof(found) + 1  ! calls fill it
      status = c_mesh_describe_weld(self%handle, handle, found, c_null_ptr, 0_c_int64_t, length)
      if (present(report)) report = found
      if (status == CLSDF_OK .and. present(warning)) then
        allocate (text(length + 1))
        status = c_mesh_describe_weld(self%handle, handle, found, c_loc(text), length + 1, written)
        warning = clsdf_text(c_loc(text))
      end if
    end if
    call welded%release()
    welded%handle = handle
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> A terrain closed by walls from its rim down to z = floor, and by a floor there: what CLSDF_SIGN_BELOW takes to be
  !> inside. The vertices and triangles of the mesh come first.
  subroutine mesh_close_down(self, floor, closed, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    real(c_double), intent(in) :: floor
    type(clsdf_mesh), intent(inout) :: closed
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ptr) :: handle
    integer(c_int32_t) :: status
    status = c_mesh_close_down(self%handle, floor, handle)
    call closed%release()
    closed%handle = handle
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The outer surface of a mesh whose parts may overlap, touch, repeat or contain each other: closed, its faces look
  !> outwards. sign: CLSDF_SIGN_AUTOMATIC, CLSDF_SIGN_NONZERO or CLSDF_SIGN_PARITY.
  subroutine mesh_outer(self, outer, sign, report, options, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    type(clsdf_mesh), intent(inout) :: outer
    integer(c_int32_t), intent(in), optional :: sign
    type(clsdf_outer_report), intent(out), optional :: report
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    type(clsdf_outer_report) :: found
    type(c_ptr) :: handle
    integer(c_int32_t) :: status, rule
    rule = CLSDF_SIGN_AUTOMATIC
    if (present(sign)) rule = sign
    found%struct_size = c_sizeof(found) + 1  ! calls fill it
    status = c_mesh_outer(self%handle, rule, options_for_c(given, options), handle, found)
    if (present(report)) report = found
    call outer%release()
    outer%handle = handle
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The options of a convention: 'plain', 'amrex', 'chombo' or 'vtk'.
  function clsdf_fraction_convention(name, stat, errmsg) result(options)
    character(*), intent(in) :: name
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_fraction_options) :: options
    integer(c_int32_t) :: status
    options%struct_size = c_sizeof(options)
    status = c_fraction_convention(trim(name)//c_null_char, options)
    call clsdf_finish(status, stat, errmsg)
  end function

  !> The cells of a grid that the surface meets, by z, y, x: the parts that the mesh fills. A mesh of outer() is used as it
  !> is; of others the outer surface is made.
  subroutine mesh_fractions(self, grid, cells, options, sign, call_options, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_cell_fraction), allocatable, intent(out) :: cells(:)
    type(clsdf_fraction_options), intent(in), optional :: options
    integer(c_int32_t), intent(in), optional :: sign
    class(clsdf_call_options), intent(inout), target, optional :: call_options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(cell_taker), target :: taker
    type(caller), target :: given
    type(clsdf_fraction_options) :: own
    integer(c_int32_t) :: status, rule
    integer(c_int64_t) :: n
    rule = CLSDF_SIGN_AUTOMATIC
    if (present(sign)) rule = sign
    if (present(options)) own = options
    own%struct_size = c_sizeof(own)
    status = c_fractions(self%handle, rule, [clsdf_grid_for_c(grid)], 1_c_int64_t, own, c_funloc(on_cells), c_loc(taker), &
        options_for_c(given, call_options))
    if (status == CLSDF_OK) then
      call move_alloc(taker%cells, cells)
      do n = 1, size(cells, kind=c_int64_t)
        cells(n)%cell = cells(n)%cell + 1
      end do
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  function on_cells(user, grid_number, cells, cell_count, full) bind(C, name="") result(status)
    type(c_ptr), value :: user, cells, full
    integer(c_int64_t), value :: grid_number, cell_count
    integer(c_int32_t) :: status
    type(cell_taker), pointer :: taker
    type(clsdf_cell_fraction), pointer :: found(:)
    status = CLSDF_OK
    if (grid_number /= 0 .or. .not. c_associated(full)) status = CLSDF_UNEXPECTED
    call c_f_pointer(user, taker)
    if (cell_count > 0) then
      call c_f_pointer(cells, found, [cell_count])
      taker%cells = found
    else
      allocate (taker%cells(0))
    end if
  end function

  !> The same into arrays of boxes.
  subroutine mesh_fraction_arrays(self, requests, options, sign, call_options, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    type(clsdf_fraction_request), intent(in) :: requests(:)
    type(clsdf_fraction_options), intent(in), optional :: options
    integer(c_int32_t), intent(in), optional :: sign
    class(clsdf_call_options), intent(inout), target, optional :: call_options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_fraction_request) :: c(size(requests))
    type(caller), target :: given
    type(clsdf_fraction_options) :: own
    integer(c_int32_t) :: status, rule
    integer(c_int64_t) :: cells(3), faces(3)
    integer :: n, axis
    status = CLSDF_OK
    rule = CLSDF_SIGN_AUTOMATIC
    if (present(sign)) rule = sign
    if (present(options)) own = options
    own%struct_size = c_sizeof(own)
    do n = 1, size(requests)
      associate (from => requests(n), to => c(n))
        to%grid = clsdf_grid_for_c(from%grid)
        cells = from%grid%size - 1
        call cells_for_c(from%types, 'types', 1_c_int64_t, cells, to%types)
        call cells_for_c(from%pieces, 'pieces', 1_c_int64_t, cells, to%pieces)
        call cells_for_c(from%volume, 'volume', 1_c_int64_t, cells, to%volume)
        call cells_for_c(from%centroid, 'centroid', 3_c_int64_t, cells, to%centroid)
        call cells_for_c(from%area, 'area', 1_c_int64_t, cells, to%area)
        call cells_for_c(from%vector_area, 'vector_area', 3_c_int64_t, cells, to%vector_area)
        call cells_for_c(from%normal, 'normal', 3_c_int64_t, cells, to%normal)
        call cells_for_c(from%surface_centroid, 'surface_centroid', 3_c_int64_t, cells, to%surface_centroid)
        do axis = 1, 3
          faces = cells
          faces(axis) = faces(axis) + 1
          call cells_for_c(from%face_fractions(axis), 'face_fractions', 1_c_int64_t, faces, to%face_fractions(axis))
          call cells_for_c(from%face_centroids(axis), 'face_centroids', 2_c_int64_t, faces, to%face_centroids(axis))
        end do
      end associate
    end do
    if (status == CLSDF_OK) status = c_fraction_arrays(self%handle, rule, c, size(c, kind=c_int64_t), own, &
        options_for_c(given, call_options))
    call clsdf_finish(status, stat, errmsg)
  contains
    subroutine cells_for_c(array, what, components, items, to)
      type(clsdf_array), intent(in) :: array
      character(*), intent(in) :: what
      integer(c_int64_t), intent(in) :: components, items(3)
      type(clsdf_c_array), intent(inout) :: to
      if (status /= CLSDF_OK .or. .not. (c_associated(array%device) .or. array%rank > 0)) return
      call for_c(array, what, components, items, 3, to, status)
    end subroutine
  end subroutine

  !> A copy: of each triangle of an outer surface the number, from 1, of the face as given that it is a part of; empty of
  !> other meshes.
  subroutine mesh_given_faces(self, faces, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    integer(c_int32_t), allocatable, intent(out) :: faces(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ptr) :: first
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    status = c_mesh_given_faces(self%handle, first, count)
    call numbers_from_1(status, first, count, faces)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The same for a mesh of scene%outer(): the body of each triangle, from 1; the faces count within its mesh.
  subroutine mesh_given_bodies(self, bodies, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    integer(c_int32_t), allocatable, intent(out) :: bodies(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ptr) :: first
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    status = c_mesh_given_bodies(self%handle, first, count)
    call numbers_from_1(status, first, count, bodies)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> A copy of numbers that count from 0 in C; empty after an error.
  subroutine numbers_from_1(status, first, count, numbers)
    integer(c_int32_t), intent(in) :: status
    type(c_ptr), intent(in) :: first
    integer(c_int64_t), intent(in) :: count
    integer(c_int32_t), allocatable, intent(out) :: numbers(:)
    integer(c_int32_t), pointer :: from_0(:)
    if (status == CLSDF_OK .and. count > 0) then
      call c_f_pointer(first, from_0, [count])
      numbers = from_0 + 1
    else
      allocate (numbers(0))
    end if
  end subroutine

  !> Writes by the file's ending, complete or not at all. colours(3, triangles): red, green, blue, as unsigned bytes.
  subroutine mesh_write(self, path, colours, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    character(*), intent(in) :: path
    integer(c_int8_t), intent(in), target, contiguous, optional :: colours(:, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ptr) :: first
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    first = c_null_ptr
    count = 0
    status = CLSDF_OK
    if (present(colours)) then
      count = size(colours, 2, c_int64_t)
      if (size(colours, kind=c_int64_t) > 0) first = c_loc(colours)
      if (size(colours, 1) /= 3) status = refused('the array of the colours has the shape '// &
          joined(shape(colours, c_int64_t))//'; give it (3, triangles)')
    end if
    if (status == CLSDF_OK) status = c_mesh_write(self%handle, trim(path)//c_null_char, first, count)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> New positions of the same vertices, on the host.
  subroutine mesh_set_positions(self, positions, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    type(clsdf_array), intent(in) :: positions
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_array) :: c
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call rows_for_c(positions, 'positions', c, status)
    if (status == CLSDF_OK) status = c_mesh_set_positions(self%handle, c)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> What triangles of transforms of this mesh count from, from now on: 1, or 0 for triangles in memory of the device,
  !> where the library counts from 0.
  subroutine mesh_set_index_base(self, index_base, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    integer, intent(in) :: index_base
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_mesh_set_index_base(self%handle, int(index_base, c_int32_t)), stat, errmsg)
  end subroutine

  function mesh_index_base(self, stat, errmsg) result(index_base)
    class(clsdf_mesh), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: index_base
    call clsdf_finish(c_mesh_index_base(self%handle, index_base), stat, errmsg)
  end function

  !> The mesh's own memory: (3, vertices), as long as the mesh lives. set_positions() writes the new positions there.
  subroutine mesh_vertices(self, vertices, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    real(c_double), pointer, intent(out) :: vertices(:, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ptr) :: first
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    vertices => null()
    status = c_mesh_vertices(self%handle, first, count)
    if (status == CLSDF_OK) call c_f_pointer(first, vertices, [3_c_int64_t, count])
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> A copy: (3, triangles), from 1.
  subroutine mesh_triangles(self, triangles, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    integer(c_int32_t), allocatable, intent(out) :: triangles(:, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t), pointer :: from_0(:, :)
    type(c_ptr) :: first
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    status = c_mesh_triangles(self%handle, first, count)
    if (status == CLSDF_OK) then
      call c_f_pointer(first, from_0, [3_c_int64_t, count])
      triangles = from_0 + 1
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  function mesh_name(self, stat, errmsg) result(name)
    class(clsdf_mesh), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    character(:), allocatable :: name
    type(c_ptr) :: text
    integer(c_int32_t) :: status
    text = c_null_ptr
    status = c_mesh_name(self%handle, text)
    name = ''
    if (status == CLSDF_OK) name = clsdf_text(text)
    call clsdf_finish(status, stat, errmsg)
  end function

  !> The number of groups of triangles; 0 if the mesh has none.
  function mesh_group_count(self, stat, errmsg) result(count)
    class(clsdf_mesh), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    count = 0
    status = c_mesh_group_count(self%handle, count)
    call clsdf_finish(status, stat, errmsg)
  end function

  !> The name of a group, from 1; all are different.
  function mesh_group_name(self, group, stat, errmsg) result(name)
    class(clsdf_mesh), intent(in) :: self
    integer, intent(in) :: group
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    character(:), allocatable :: name
    type(c_ptr) :: text
    integer(c_int32_t) :: status
    text = c_null_ptr
    status = c_mesh_group_name(self%handle, int(group, c_int64_t) - 1, text)
    name = ''
    if (status == CLSDF_OK) name = clsdf_text(text)
    call clsdf_finish(status, stat, errmsg)
  end function

  !> A copy: the group of each triangle, from 1; empty if the mesh has no groups. That of the triangle t of a point, a link,
  !> a crossing or a ray is mesh%group_name(numbers(t)).
  subroutine mesh_group_numbers(self, numbers, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    integer(c_int32_t), allocatable, intent(out) :: numbers(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t), pointer :: from_0(:)
    type(c_ptr) :: first
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    status = c_mesh_group_numbers(self%handle, first, count)
    if (status == CLSDF_OK .and. count > 0) then
      call c_f_pointer(first, from_0, [count])
      numbers = from_0 + 1
    else
      allocate (numbers(0))
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Sets the groups of the triangles: names, whose blanks at the end do not count, and a number from 1 for each
  !> triangle. None of both removes the groups.
  subroutine mesh_set_groups(self, names, numbers, stat, errmsg)
    class(clsdf_mesh), intent(inout) :: self
    character(*), intent(in) :: names(:)
    integer(c_int32_t), intent(in) :: numbers(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    character(kind=c_char), target :: texts(len(names) + 1, size(names))
    type(c_ptr) :: pointers(size(names))
    call texts_for_c(names, texts, pointers)
    call clsdf_finish(c_mesh_set_groups(self%handle, pointers, size(names, kind=c_int64_t), numbers - 1, &
      size(numbers, kind=c_int64_t)), stat, errmsg)
  end subroutine

  !> Of the vertices in use.
  function mesh_box(self, stat, errmsg) result(box)
    class(clsdf_mesh), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_box) :: box
    call clsdf_finish(c_mesh_box(self%handle, box), stat, errmsg)
  end function

  !> Of all vertices and triangles in their order, the same on every machine: tells whether ranks have the same mesh. The
  !> index base and the name do not count.
  function mesh_hash(self, stat, errmsg) result(hash)
    class(clsdf_mesh), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: hash
    hash = 0
    call clsdf_finish(c_mesh_hash(self%handle, hash), stat, errmsg)
  end function

  function mesh_topology(self, stat, errmsg) result(topology)
    class(clsdf_mesh), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_topology) :: topology
    type(c_topology) :: c
    c%struct_size = c_sizeof(c) + 1  ! calls fill it
    call clsdf_finish(c_mesh_topology(self%handle, c), stat, errmsg)
    call take_topology(c, topology)
  end function

  subroutine take_topology(c, topology)
    type(c_topology), intent(in) :: c
    type(clsdf_topology), intent(out) :: topology
    topology%closed = c%closed == 1
    topology%balanced = c%balanced == 1
    topology%inside_out = c%inside_out == 1
    topology%open_edges = c%open_edges
    topology%unbalanced_edges = c%unbalanced_edges
    topology%non_manifold_edges = c%non_manifold_edges
    topology%repeated_vertex_faces = c%repeated_vertex_faces
    topology%coincident_vertices = c%coincident_vertices
    topology%unused_vertices = c%unused_vertices
    topology%first_open = c%first_open(1:c%first_open_count)
    topology%first_unbalanced = c%first_unbalanced(1:c%first_unbalanced_count)
    topology%boundary_edges = c%boundary_edges
    topology%joined_vertices = c%joined_vertices
    topology%duplicate_faces = c%duplicate_faces
    topology%uncounted_faces = c%uncounted_faces
    topology%reoriented_faces = c%reoriented_faces
    topology%inner_wall_faces = c%inner_wall_faces
    topology%first_inner_wall_face = c%first_inner_wall_face
    topology%parts = c%parts
    topology%inward_parts = c%inward_parts
    topology%first_inward_face = c%first_inward_face
    topology%nested_parts = c%nested_parts
    topology%first_nested_face = c%first_nested_face
    topology%tested_points = c%tested_points
    topology%doubtful_points = c%doubtful_points
    topology%inside_points = c%inside_points
    topology%unclear_parts = c%unclear_parts
    topology%first_unclear_face = c%first_unclear_face
    topology%double_sided_faces = c%double_sided_faces
    topology%doubled_cavity_faces = c%doubled_cavity_faces
    topology%first_doubled_cavity_face = c%first_doubled_cavity_face
    topology%sheet_faces = c%sheet_faces
    topology%first_sheet_face = c%first_sheet_face
    topology%enclosing_faces = c%enclosing_faces
    topology%first_enclosing_face = c%first_enclosing_face
    topology%overlapping_parts = c%overlapping_parts
    topology%first_overlapping_face = c%first_overlapping_face
    topology%downward_faces = c%downward_faces
    topology%first_downward_face = c%first_downward_face
    topology%rim_loops = c%rim_loops
    topology%overlapping_rim_edges = c%overlapping_rim_edges
    topology%detail_parts = c%detail_parts
    topology%detail_faces = c%detail_faces
    topology%first_detail_face = c%first_detail_face
    topology%partial_faces = c%partial_faces
    topology%hidden_faces = c%hidden_faces
  end subroutine

  !> Defects beside those of edges.
  function mesh_defects(self, stat, errmsg) result(defects)
    class(clsdf_mesh), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_defects) :: defects
    defects%struct_size = c_sizeof(defects) + 1  ! calls fill it
    call clsdf_finish(c_mesh_defects(self%handle, defects), stat, errmsg)
  end function

  !> The rule that a transform would use, and a warning about it, which may be "".
  subroutine mesh_sign(self, rule, asked, warning, stat, errmsg)
    class(clsdf_mesh), intent(in) :: self
    integer(c_int32_t), intent(out) :: rule
    integer(c_int32_t), intent(in), optional :: asked
    character(:), allocatable, intent(out), optional :: warning
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    character(kind=c_char), allocatable, target :: text(:)
    integer(c_int64_t) :: length, written
    integer(c_int32_t) :: status, wanted
    wanted = CLSDF_SIGN_AUTOMATIC
    if (present(asked)) wanted = asked
    status = c_mesh_sign(self%handle, wanted, rule, c_null_ptr, 0_c_int64_t, length)
    if (status == CLSDF_OK .and. present(warning)) then
      allocate (text(length + 1))
      status = c_mesh_sign(self%handle, wanted, rule, c_loc(text), length + 1, written)
      warning = clsdf_text(c_loc(text))
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  function clsdf_shape_count() result(count)
    integer(c_int64_t) :: count
    count = c_shape_count()
  end function

  !> Of shape 1 to clsdf_shape_count(); "" beyond.
  function clsdf_shape_name(index) result(name)
    integer, intent(in) :: index
    character(:), allocatable :: name
    name = clsdf_text(c_shape_name(int(index - 1, c_int64_t)))
  end function

  function clsdf_shape_description(index) result(description)
    integer, intent(in) :: index
    character(:), allocatable :: description
    description = clsdf_text(c_shape_description(int(index - 1, c_int64_t)))
  end function

  ! ---- Transforms ----

  !> Copies and checks the mesh. Compiles nothing: the first call that needs a program does. `kept_bytes`: limit of the
  !> device memory kept between calls; 0: none; -1: the default. `floor`: of CLSDF_SIGN_BELOW, z below all vertices.
  !> `surface`: CLSDF_SURFACE_GIVEN, the default, or CLSDF_SURFACE_OUTER.
  subroutine transform_create(self, device, mesh, sign, kept_bytes, options, stat, errmsg, floor, surface)
    class(clsdf_transform), intent(inout) :: self
    type(clsdf_device), intent(in) :: device
    type(clsdf_mesh), intent(in) :: mesh
    integer(c_int32_t), intent(in), optional :: sign
    integer(c_int64_t), intent(in), optional :: kept_bytes
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), intent(in), optional :: floor
    integer(c_int32_t), intent(in), optional :: surface
    type(caller), target :: given
    call self%release()
    call clsdf_finish(c_transform_create(device%handle, mesh%handle, transform_options(sign, kept_bytes, floor, surface), &
        options_for_c(given, options), self%handle), stat, errmsg)
  end subroutine

  function transform_options(sign, kept_bytes, floor, surface) result(c)
    integer(c_int32_t), intent(in), optional :: sign
    integer(c_int64_t), intent(in), optional :: kept_bytes
    real(c_double), intent(in), optional :: floor
    integer(c_int32_t), intent(in), optional :: surface
    type(c_transform_options) :: c
    c%struct_size = c_sizeof(c)
    if (present(sign)) c%sign = sign
    if (present(kept_bytes)) c%kept_bytes = kept_bytes
    if (present(floor)) c%floor = floor
    if (present(surface)) c%surface = surface
  end function

  !> The same from arrays, which may be buffers of the device's context: triangles in a buffer count from 0, here and in
  !> results.
  subroutine transform_from_arrays(self, device, vertices, triangles, name, sign, kept_bytes, options, stat, errmsg, &
      floor, surface)
    class(clsdf_transform), intent(inout) :: self
    type(clsdf_device), intent(in) :: device
    type(clsdf_array), intent(in) :: vertices, triangles
    character(*), intent(in), optional :: name
    integer(c_int32_t), intent(in), optional :: sign
    integer(c_int64_t), intent(in), optional :: kept_bytes
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), intent(in), optional :: floor
    integer(c_int32_t), intent(in), optional :: surface
    type(caller), target :: given
    type(c_mesh_arrays) :: c
    character(:), allocatable, target :: text
    integer(c_int32_t) :: status
    call self%release()
    call mesh_for_c(vertices, triangles, name, c, text, status)
    if (status == CLSDF_OK) status = c_transform_from_arrays(device%handle, c, &
        transform_options(sign, kept_bytes, floor, surface), options_for_c(given, options), self%handle)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED FOR r8

  subroutine transform_create_r4(self, device, vertices, triangles, name, sign, kept_bytes, options, stat, errmsg, floor, &
      surface)
    class(clsdf_transform), intent(inout) :: self
    type(clsdf_device), intent(in) :: device
    real(c_float), intent(in), target :: vertices(:, :)
    integer(c_int32_t), intent(in), target :: triangles(:, :)
    character(*), intent(in), optional :: name
    integer(c_int32_t), intent(in), optional :: sign
    integer(c_int64_t), intent(in), optional :: kept_bytes
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), intent(in), optional :: floor
    integer(c_int32_t), intent(in), optional :: surface
    call self%create(device, clsdf_array(vertices), clsdf_array(triangles), name, sign, kept_bytes, options, stat, &
        errmsg, floor, surface)
  end subroutine

  subroutine set_positions_r4(self, positions, options, stat, errmsg)
    class(clsdf_transform), intent(inout) :: self
    real(c_float), intent(in), target :: positions(:, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%set_positions(clsdf_array(positions), options, stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  subroutine transform_create_r8(self, device, vertices, triangles, name, sign, kept_bytes, options, stat, errmsg, floor, &
      surface)
    class(clsdf_transform), intent(inout) :: self
    type(clsdf_device), intent(in) :: device
    real(c_double), intent(in), target :: vertices(:, :)
    integer(c_int32_t), intent(in), target :: triangles(:, :)
    character(*), intent(in), optional :: name
    integer(c_int32_t), intent(in), optional :: sign
    integer(c_int64_t), intent(in), optional :: kept_bytes
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), intent(in), optional :: floor
    integer(c_int32_t), intent(in), optional :: surface
    call self%create(device, clsdf_array(vertices), clsdf_array(triangles), name, sign, kept_bytes, options, stat, &
        errmsg, floor, surface)
  end subroutine

  subroutine set_positions_r8(self, positions, options, stat, errmsg)
    class(clsdf_transform), intent(inout) :: self
    real(c_double), intent(in), target :: positions(:, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%set_positions(clsdf_array(positions), options, stat, errmsg)
  end subroutine

  ! END

  !> A transform for a part of the domain, which keeps only what the regions need. With a margin its vertices may move by
  !> up to that length from where they are now: set_positions takes those of part_vertices.
  subroutine transform_restrict(self, regions, restricted, stat, errmsg, margin)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_region), intent(in) :: regions(:)
    type(clsdf_transform), intent(inout) :: restricted
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), intent(in), optional :: margin
    type(c_ptr) :: handle
    integer(c_int32_t) :: status
    real(c_double) :: way
    way = 0
    if (present(margin)) way = margin
    status = c_transform_restrict_with_margin(self%handle, regions, size(regions, kind=c_int64_t), way, handle)
    call restricted%release()
    restricted%handle = handle
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The vertices of a part with a margin, ascending, by their numbers in the mesh of the whole, from 1; of vertices with
  !> equal coordinates the lowest.
  subroutine transform_part_vertices(self, vertices, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    integer(c_int32_t), allocatable, target, intent(out) :: vertices(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: room, count
    integer(c_int32_t) :: status
    status = c_transform_part_vertices(self%handle, c_null_ptr, 0_c_int64_t, room)
    allocate(vertices(room))
    if (status == 0) status = c_transform_part_vertices(self%handle, c_loc(vertices), room, count)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> A restricted transform as bytes, for another process or for later; see create_from_part.
  subroutine transform_part_bytes(self, bytes, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    integer(c_int8_t), allocatable, target, intent(out) :: bytes(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: room, count
    integer(c_int32_t) :: status
    status = c_transform_part_bytes(self%handle, c_null_ptr, 0_c_int64_t, room)
    allocate(bytes(room))
    if (status == 0) status = c_transform_part_bytes(self%handle, c_loc(bytes), room, count)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The restricted transform of bytes that part_bytes gave, without the mesh, on any device. They are of the same version
  !> of clsdf and of this kind of machine; damaged or foreign bytes are an error. kept_bytes: as of create. index_base: of
  !> its triangles, 0 or 1 (default: 1).
  subroutine transform_create_from_part(self, device, bytes, stat, errmsg, kept_bytes, index_base)
    class(clsdf_transform), intent(inout) :: self
    type(clsdf_device), intent(in) :: device
    integer(c_int8_t), intent(in) :: bytes(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t), intent(in), optional :: kept_bytes
    integer, intent(in), optional :: index_base
    call self%release()
    call clsdf_finish(c_transform_from_part(device%handle, bytes, size(bytes, kind=c_int64_t), base_or_1(index_base), &
        kept_or_default(kept_bytes), self%handle), stat, errmsg)
  end subroutine

  function base_or_1(index_base) result(base)
    integer, intent(in), optional :: index_base
    integer(c_int32_t) :: base
    base = 1
    if (present(index_base)) base = int(index_base, c_int32_t)
  end function

  function kept_or_default(kept_bytes) result(bytes)
    integer(c_int64_t), intent(in), optional :: kept_bytes
    integer(c_int64_t) :: bytes
    bytes = -1
    if (present(kept_bytes)) bytes = kept_bytes
  end function

  !> The bytes of memory that share needs: about 640 for each triangle. Makes what is not made yet. A transform that is
  !> restricted, has moved, or is of the outer surface is an error.
  subroutine transform_prepared_bytes(self, bytes, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    integer(c_int64_t), intent(out) :: bytes
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_transform_prepared_bytes(self%handle, bytes), stat, errmsg)
  end subroutine

  !> Writes the prepared mesh into memory that processes of a node share, as a window of MPI, from a multiple of 64 bytes on.
  !> Until the call returns, create_from_shared refuses the memory.
  subroutine transform_share(self, memory, bytes, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(c_ptr), intent(in) :: memory
    integer(c_int64_t), intent(in) :: bytes
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_transform_share(self%handle, memory, bytes), stat, errmsg)
  end subroutine

  !> A whole transform that reads the prepared mesh in place. The memory stays as it is until the transform and its plans
  !> are released. Memory without a complete transform, damaged, or of another version of clsdf is an error. kept_bytes: as
  !> of create. index_base: of its triangles, 0 or 1 (default: 1).
  subroutine transform_create_from_shared(self, device, memory, bytes, stat, errmsg, kept_bytes, index_base)
    class(clsdf_transform), intent(inout) :: self
    type(clsdf_device), intent(in) :: device
    type(c_ptr), intent(in) :: memory
    integer(c_int64_t), intent(in) :: bytes
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t), intent(in), optional :: kept_bytes
    integer, intent(in), optional :: index_base
    call self%release()
    call clsdf_finish(c_transform_from_shared(device%handle, memory, bytes, base_or_1(index_base), &
        kept_or_default(kept_bytes), self%handle), stat, errmsg)
  end subroutine

  !> New positions of all vertices, on the host or in a buffer. After an error the positions are those of before.
  subroutine set_positions_array(self, positions, options, stat, errmsg)
    class(clsdf_transform), intent(inout) :: self
    type(clsdf_array), intent(in) :: positions
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    type(clsdf_c_array) :: c
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call rows_for_c(positions, 'positions', c, status)
    if (status == CLSDF_OK) status = c_transform_set_positions(self%handle, c, options_for_c(given, options))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Puts the vertices at matmul(rotation, x) + translation; x are the positions that the transform was made with.
  subroutine transform_set_motion(self, rotation, translation, stat, errmsg)
    class(clsdf_transform), intent(inout) :: self
    real(c_double), intent(in) :: rotation(3, 3), translation(3)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double) :: rows(9)
    rows = reshape(transpose(rotation), [9])
    call clsdf_finish(c_transform_set_motion(self%handle, rows, translation), stat, errmsg)
  end subroutine

  !> The field on a grid, into arrays of any kinds, all on the host or all on the device.
  subroutine compute_targets(self, grid, band, targets, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    type(clsdf_target), intent(in) :: targets(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_target) :: c(size(targets))
    type(caller), target :: given
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call clsdf_targets_of_samples(targets, grid%size, 3, c, status)
    if (status == CLSDF_OK) status = c_compute(self%handle, clsdf_grid_for_c(grid), band, c, &
        size(targets, kind=c_int64_t), options_for_c(given, options), statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED FOR r8 closest

  !> The same with arrays of one kind.
  subroutine compute_r4(self, grid, band, distance, triangle, site, offset, gradient, barycentric, &
      options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    real(c_float), intent(inout), target :: distance(:, :, :)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:, :, :)
    integer(c_int8_t), intent(inout), target, optional :: site(:, :, :)
    real(c_float), intent(inout), target, optional :: offset(:, :, :, :), gradient(:, :, :, :), barycentric(:, :, :, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_target) :: targets(6)
    targets(1) = clsdf_target(CLSDF_DISTANCE, distance)
    if (present(triangle)) targets(2) = clsdf_target(CLSDF_TRIANGLE, triangle)
    if (present(site)) targets(3) = clsdf_target(CLSDF_SITE, site)
    if (present(offset)) targets(4) = clsdf_target(CLSDF_OFFSET, offset)
    if (present(gradient)) targets(5) = clsdf_target(CLSDF_GRADIENT, gradient)
    if (present(barycentric)) targets(6) = clsdf_target(CLSDF_BARYCENTRIC, barycentric)
    call self%compute(grid, band, pack(targets, targets%output >= 0), options, statistics, stat, errmsg)
  end subroutine

  !> Equal blocks of the grid's lattice: distance(i, j, k, block), gradient(3, i, j, k, block). Block n starts with the
  !> sample first(:, n) of the lattice.
  subroutine compute_blocks_r4(self, lattice, band, first, distance, triangle, site, offset, gradient, barycentric, &
      options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: lattice
    type(clsdf_band), intent(in) :: band
    integer, intent(in) :: first(:, :)
    real(c_float), intent(inout), target :: distance(:, :, :, :)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:, :, :, :)
    integer(c_int8_t), intent(inout), target, optional :: site(:, :, :, :)
    real(c_float), intent(inout), target, optional :: offset(:, :, :, :, :), gradient(:, :, :, :, :), barycentric(:, :, :, :, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_block_set) :: blocks
    type(clsdf_target) :: targets(6)
    integer(c_int64_t) :: samples(4)
    samples = shape(distance, c_int64_t)
    blocks%lattice = lattice
    blocks%band = band
    blocks%size = samples(1:3)
    blocks%first = first
    targets(1) = clsdf_target(CLSDF_DISTANCE, distance)
    if (present(triangle)) targets(2) = clsdf_target(CLSDF_TRIANGLE, triangle)
    if (present(site)) targets(3) = clsdf_target(CLSDF_SITE, site)
    if (present(offset)) targets(4) = clsdf_target(CLSDF_OFFSET, offset)
    if (present(gradient)) targets(5) = clsdf_target(CLSDF_GRADIENT, gradient)
    if (present(barycentric)) targets(6) = clsdf_target(CLSDF_BARYCENTRIC, barycentric)
    blocks%targets = pack(targets, targets%output >= 0)
    call self%compute_blocks(blocks, options, statistics, stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  !> The same with arrays of one kind.
  subroutine compute_r8(self, grid, band, distance, triangle, site, closest, gradient, barycentric, offset, &
      options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    real(c_double), intent(inout), target :: distance(:, :, :)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:, :, :)
    integer(c_int8_t), intent(inout), target, optional :: site(:, :, :)
    real(c_double), intent(inout), target, optional :: closest(:, :, :, :), gradient(:, :, :, :), barycentric(:, :, :, :)
    real(c_double), intent(inout), target, optional :: offset(:, :, :, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_target) :: targets(7)
    targets(1) = clsdf_target(CLSDF_DISTANCE, distance)
    if (present(triangle)) targets(2) = clsdf_target(CLSDF_TRIANGLE, triangle)
    if (present(site)) targets(3) = clsdf_target(CLSDF_SITE, site)
    if (present(closest)) targets(4) = clsdf_target(CLSDF_CLOSEST, closest)
    if (present(gradient)) targets(5) = clsdf_target(CLSDF_GRADIENT, gradient)
    if (present(barycentric)) targets(6) = clsdf_target(CLSDF_BARYCENTRIC, barycentric)
    if (present(offset)) targets(7) = clsdf_target(CLSDF_OFFSET, offset)
    call self%compute(grid, band, pack(targets, targets%output >= 0), options, statistics, stat, errmsg)
  end subroutine

  !> Equal blocks of the grid's lattice: distance(i, j, k, block), gradient(3, i, j, k, block). Block n starts with the
  !> sample first(:, n) of the lattice.
  subroutine compute_blocks_r8(self, lattice, band, first, distance, triangle, site, closest, gradient, barycentric, offset, &
      options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: lattice
    type(clsdf_band), intent(in) :: band
    integer, intent(in) :: first(:, :)
    real(c_double), intent(inout), target :: distance(:, :, :, :)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:, :, :, :)
    integer(c_int8_t), intent(inout), target, optional :: site(:, :, :, :)
    real(c_double), intent(inout), target, optional :: closest(:, :, :, :, :), gradient(:, :, :, :, :), barycentric(:, :, :, :, :)
    real(c_double), intent(inout), target, optional :: offset(:, :, :, :, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_block_set) :: blocks
    type(clsdf_target) :: targets(7)
    integer(c_int64_t) :: samples(4)
    samples = shape(distance, c_int64_t)
    blocks%lattice = lattice
    blocks%band = band
    blocks%size = samples(1:3)
    blocks%first = first
    targets(1) = clsdf_target(CLSDF_DISTANCE, distance)
    if (present(triangle)) targets(2) = clsdf_target(CLSDF_TRIANGLE, triangle)
    if (present(site)) targets(3) = clsdf_target(CLSDF_SITE, site)
    if (present(closest)) targets(4) = clsdf_target(CLSDF_CLOSEST, closest)
    if (present(gradient)) targets(5) = clsdf_target(CLSDF_GRADIENT, gradient)
    if (present(barycentric)) targets(6) = clsdf_target(CLSDF_BARYCENTRIC, barycentric)
    if (present(offset)) targets(7) = clsdf_target(CLSDF_OFFSET, offset)
    blocks%targets = pack(targets, targets%output >= 0)
    call self%compute_blocks(blocks, options, statistics, stat, errmsg)
  end subroutine

  ! END

  !> Many boxes in one call, of any lattices, bands and outputs.
  subroutine compute_requests(self, requests, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_request), intent(in) :: requests(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(request_list), target :: c
    type(caller), target :: given
    integer(c_int32_t) :: status
    call requests_for_c(requests, c, status)
    if (status == CLSDF_OK) status = c_compute_requests(self%handle, c%items, size(requests, kind=c_int64_t), &
        options_for_c(given, options), statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine requests_for_c(requests, c, status)
    type(clsdf_request), intent(in) :: requests(:)
    type(request_list), intent(inout), target :: c
    integer(c_int32_t), intent(out) :: status
    integer :: i, begin, count
    status = CLSDF_OK
    count = 0
    do i = 1, size(requests)
      if (allocated(requests(i)%targets)) count = count + size(requests(i)%targets)
    end do
    allocate (c%items(size(requests)), c%targets(count))
    begin = 1
    do i = 1, size(requests)
      c%items(i)%grid = clsdf_grid_for_c(requests(i)%grid)
      c%items(i)%band = requests(i)%band
      if (.not. allocated(requests(i)%targets)) cycle
      count = size(requests(i)%targets)
      if (count == 0) cycle
      call clsdf_targets_of_samples(requests(i)%targets, requests(i)%grid%size, 3, c%targets(begin:begin + count - 1), &
          status)
      if (status /= CLSDF_OK) return
      c%items(i)%targets = c_targets(c_loc(c%targets(begin)), int(count, c_int64_t))
      begin = begin + count
    end do
  end subroutine

  !> Equal blocks of one lattice in one call.
  subroutine compute_block_set(self, blocks, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_block_set), intent(in) :: blocks
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(block_list), target :: c
    type(caller), target :: given
    integer(c_int32_t) :: status
    call blocks_for_c(blocks, c, status)
    if (status == CLSDF_OK) status = c_compute_blocks(self%handle, c%c, options_for_c(given, options), &
        statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine blocks_for_c(blocks, c, status)
    type(clsdf_block_set), intent(in) :: blocks
    type(block_list), intent(inout), target :: c
    integer(c_int32_t), intent(out) :: status
    status = CLSDF_OK
    c%c%struct_size = c_sizeof(c%c)
    c%c%lattice = clsdf_grid_for_c(blocks%lattice)
    c%c%band = blocks%band
    c%c%size = blocks%size
    if (allocated(blocks%first)) c%first = blocks%first - 1
    if (.not. allocated(c%first)) allocate (c%first(3, 0))
    if (size(c%first, 1) /= 3) then
      status = refused('the array of the blocks has the shape '//joined(shape(c%first, c_int64_t))//'; give it (3, blocks)')
      return
    end if
    c%c%block_count = size(c%first, 2, c_int64_t)
    if (size(c%first) > 0) c%c%first = c_loc(c%first)
    if (.not. allocated(blocks%targets)) return
    if (size(blocks%targets) == 0) return
    allocate (c%targets(size(blocks%targets)))
    call clsdf_targets_of_samples(blocks%targets, [blocks%size, c%c%block_count], 3, c%targets, status)
    c%c%targets = c_targets(c_loc(c%targets), size(c%targets, kind=c_int64_t))
  end subroutine

  !> A field of any size, slab by slab in the order of z.
  subroutine transform_compute_slabs(self, grid, band, sink, outputs, own_thread, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    class(clsdf_slab_sink), intent(inout), target :: sink
    integer(c_int32_t), intent(in), optional :: outputs(:)  !< the distance alone
    logical, intent(in), optional :: own_thread  !< the sink is called on another thread, while the next slab is computed
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_slab_options), target :: slab_options
    type(slab_taker), target :: taker
    type(caller), target :: given
    integer(c_int32_t) :: status
    taker%sink => sink
    slab_options%struct_size = c_sizeof(slab_options)
    if (present(own_thread)) slab_options%own_thread = merge(1, 0, own_thread)
    status = c_transform_index_base(self%handle, taker%index_base)
    if (status == CLSDF_OK) status = c_compute_slabs(self%handle, clsdf_grid_for_c(grid), band, &
        clsdf_outputs_mask(outputs), c_funloc(on_slab), c_loc(taker), c_loc(slab_options), options_for_c(given, options), &
        statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The field in memory of the library.
  subroutine transform_compute_field(self, grid, band, field, outputs, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    type(clsdf_field), intent(inout) :: field
    integer(c_int32_t), intent(in), optional :: outputs(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call field%release()
    call clsdf_finish(c_compute_field(self%handle, clsdf_grid_for_c(grid), band, clsdf_outputs_mask(outputs), &
        options_for_c(given, options), statistics_for_c(statistics), field%handle), stat, errmsg)
  end subroutine

  !> A sparse field into arrays of the program: the bricks near the surface, and the sign of the rest. `counts` says how
  !> many bricks and runs there are. If the arrays have less room, the call is CLSDF_INVALID_ARGUMENT, and `counts` is set.
  !> bricks(:, n) is the first sample of brick n on the lattice, from 1; inside(:, n) the first sample of a run of bricks
  !> along x without values that are inside, and their number. targets: packed arrays (8, 8, 8, size(bricks, 2)), and
  !> (components, 8, 8, 8, size(bricks, 2)), of the types that clsdf_output_describe() states.
  subroutine compute_sparse_targets(self, grid, band, bricks, inside, targets, counts, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    integer(c_int64_t), intent(inout), contiguous, target :: bricks(:, :)  !< (3, n)
    integer(c_int64_t), intent(inout), contiguous, target :: inside(:, :)  !< (4, n)
    type(clsdf_target), intent(in) :: targets(:)
    type(clsdf_sparse_counts), intent(out) :: counts
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_target), target :: values(size(targets))
    type(c_sparse_arrays) :: c
    type(caller), target :: given
    integer(c_int32_t) :: status
    integer :: i
    status = CLSDF_OK
    c%struct_size = c_sizeof(c)
    c%brick_room = size(bricks, 2, c_int64_t)
    c%run_room = size(inside, 2, c_int64_t)
    if (size(bricks, 1) /= 3 .or. size(inside, 1) /= 4) status = refused('the arrays of the bricks and of the runs have '// &
        'the shapes '//joined(shape(bricks, c_int64_t))//' and '//joined(shape(inside, c_int64_t))// &
        '; give them (3, n) and (4, n)')
    if (status == CLSDF_OK) call clsdf_targets_of_samples(targets, [8_c_int64_t, 8_c_int64_t, 8_c_int64_t, c%brick_room], &
        3, values, status)
    do i = 1, size(targets)
      if (status /= CLSDF_OK) exit
      if (c_associated(values(i)%array%device)) cycle  ! C refuses it
      call clsdf_pack_for_c(targets(i)%array, CLSDF_BRICK_SAMPLES*c%brick_room, values(i), status)
      values(i)%array%block_stride = 0
    end do
    if (status == CLSDF_OK) then
      if (size(bricks) > 0) c%bricks = c_loc(bricks)
      if (size(inside) > 0) c%inside = c_loc(inside)
      if (size(targets) > 0) c%values = c_targets(c_loc(values), size(targets, kind=c_int64_t))
      status = c_compute_sparse(self%handle, clsdf_grid_for_c(grid), band, c, options_for_c(given, options), &
          statistics_for_c(statistics), counts)
    end if
    if (status == CLSDF_OK) then
      bricks(:, :counts%bricks) = bricks(:, :counts%bricks) + 1
      inside(:3, :counts%runs) = inside(:3, :counts%runs) + 1
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The same of the distance alone.
  subroutine compute_sparse_distance(self, grid, band, bricks, inside, distance, counts, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    integer(c_int64_t), intent(inout), contiguous, target :: bricks(:, :), inside(:, :)
    real(c_float), intent(inout), contiguous, target :: distance(:, :, :, :)  !< (8, 8, 8, size(bricks, 2))
    type(clsdf_sparse_counts), intent(out) :: counts
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%compute_sparse(grid, band, bricks, inside, [clsdf_target(CLSDF_DISTANCE, distance)], counts, options, &
        statistics, stat, errmsg)
  end subroutine

  !> How many bricks and runs compute_sparse() would give. Takes nearly its time, and no memory for values.
  subroutine transform_count_sparse(self, grid, band, counts, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    type(clsdf_sparse_counts), intent(out) :: counts
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call clsdf_finish(c_count_sparse(self%handle, clsdf_grid_for_c(grid), band, options_for_c(given, options), &
        statistics_for_c(statistics), counts), stat, errmsg)
  end subroutine

  !> A sparse field of any size: layers of bricks in the order of z.
  subroutine transform_compute_sparse_slabs(self, grid, band, sink, outputs, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    class(clsdf_sparse_sink), intent(inout), target :: sink
    integer(c_int32_t), intent(in), optional :: outputs(:)  !< the distance alone
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(sparse_taker), target :: taker
    type(caller), target :: given
    integer(c_int32_t) :: status
    taker%sink => sink
    status = c_transform_index_base(self%handle, taker%index_base)
    if (status == CLSDF_OK) status = c_compute_sparse_slabs(self%handle, clsdf_grid_for_c(grid), band, &
        clsdf_outputs_mask(outputs), c_funloc(on_sparse_slab), c_loc(taker), options_for_c(given, options), &
        statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The sparse field in memory of the library.
  subroutine compute_sparse_one(self, grid, band, field, outputs, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    type(clsdf_sparse_field), intent(inout) :: field
    integer(c_int32_t), intent(in), optional :: outputs(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    integer(c_int32_t) :: status
    call field%release()
    status = c_transform_index_base(self%handle, field%index_base)
    if (status == CLSDF_OK) status = c_compute_sparse_field(self%handle, clsdf_grid_for_c(grid), band, &
        clsdf_outputs_mask(outputs), options_for_c(given, options), statistics_for_c(statistics), field%handle)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  function sparse_request_for_c(request) result(c)
    type(clsdf_sparse_request), intent(in) :: request
    type(c_sparse_request) :: c
    c%grid = clsdf_grid_for_c(request%grid)
    c%band = request%band
    if (allocated(request%outputs)) c%outputs = clsdf_outputs_mask(request%outputs)
  end function

  !> Many sparse fields in one call, of any lattices, bands and outputs.
  subroutine compute_sparse_requests(self, requests, fields, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_sparse_request), intent(in) :: requests(:)
    type(clsdf_sparse_field), allocatable, intent(out) :: fields(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_sparse_request) :: c(size(requests))
    type(c_ptr) :: handles(size(requests))
    type(caller), target :: given
    integer(c_int32_t) :: status, index_base
    integer :: i
    do i = 1, size(requests)
      c(i) = sparse_request_for_c(requests(i))
    end do
    handles = c_null_ptr
    allocate (fields(size(requests)))
    status = c_transform_index_base(self%handle, index_base)
    if (status == CLSDF_OK) status = c_compute_sparse_requests(self%handle, c, size(requests, kind=c_int64_t), &
        options_for_c(given, options), statistics_for_c(statistics), handles)
    do i = 1, size(requests)
      fields(i)%handle = handles(i)
      fields(i)%index_base = index_base
    end do
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The distance at points of any kind, on the host or the device, and all else that has a target.
  subroutine query_targets(self, points, half_width, targets, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_array), intent(in) :: points
    real(c_double), intent(in) :: half_width
    type(clsdf_target), intent(in) :: targets(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_target) :: c(size(targets))
    type(clsdf_c_array) :: from
    type(caller), target :: given
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call rows_for_c(points, 'points', from, status)
    if (status == CLSDF_OK) call clsdf_targets_of_samples(targets, [from%count], 1, c, status)
    if (status == CLSDF_OK) status = c_query(self%handle, from, without_limit(half_width), c, &
        size(targets, kind=c_int64_t), options_for_c(given, options), statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED FOR r8 closest

  !> The same with arrays of one kind: points(3, n) or points(n, 3).
  subroutine query_r4(self, points, half_width, distance, triangle, site, offset, gradient, barycentric, &
      options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_float), intent(in), target :: points(:, :)
    real(c_double), intent(in) :: half_width
    real(c_float), intent(inout), target :: distance(:)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:)
    integer(c_int8_t), intent(inout), target, optional :: site(:)
    real(c_float), intent(inout), target, optional :: offset(:, :), gradient(:, :), barycentric(:, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_target) :: targets(6)
    targets(1) = clsdf_target(CLSDF_DISTANCE, distance)
    if (present(triangle)) targets(2) = clsdf_target(CLSDF_TRIANGLE, triangle)
    if (present(site)) targets(3) = clsdf_target(CLSDF_SITE, site)
    if (present(offset)) targets(4) = clsdf_target(CLSDF_OFFSET, offset)
    if (present(gradient)) targets(5) = clsdf_target(CLSDF_GRADIENT, gradient)
    if (present(barycentric)) targets(6) = clsdf_target(CLSDF_BARYCENTRIC, barycentric)
    call self%query(clsdf_array(points), half_width, pack(targets, targets%output >= 0), &
        options, statistics, stat, errmsg)
  end subroutine

  !> The same with an array for each coordinate. If these are not equally far apart in memory, they are copied.
  subroutine query_xyz_r4(self, x, y, z, half_width, distance, triangle, site, offset, gradient, barycentric, &
      options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_float), intent(in), target :: x(:), y(:), z(:)
    real(c_double), intent(in) :: half_width
    real(c_float), intent(inout), target :: distance(:)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:)
    integer(c_int8_t), intent(inout), target, optional :: site(:)
    real(c_float), intent(inout), target, optional :: offset(:, :), gradient(:, :), barycentric(:, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_target) :: targets(6)
    type(clsdf_array) :: points
    real(c_float), allocatable, target :: copy(:, :)
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call join(clsdf_array(x), clsdf_array(y), clsdf_array(z), points, status)
    if (status /= CLSDF_OK) then
      call clsdf_finish(status, stat, errmsg)
      return
    end if
    if (points%rank == 0) then
      allocate (copy(3, size(x, kind=c_int64_t)))
      copy(1, :) = x
      copy(2, :) = y
      copy(3, :) = z
      points = clsdf_array(copy)
    end if
    targets(1) = clsdf_target(CLSDF_DISTANCE, distance)
    if (present(triangle)) targets(2) = clsdf_target(CLSDF_TRIANGLE, triangle)
    if (present(site)) targets(3) = clsdf_target(CLSDF_SITE, site)
    if (present(offset)) targets(4) = clsdf_target(CLSDF_OFFSET, offset)
    if (present(gradient)) targets(5) = clsdf_target(CLSDF_GRADIENT, gradient)
    if (present(barycentric)) targets(6) = clsdf_target(CLSDF_BARYCENTRIC, barycentric)
    call self%query(points, half_width, pack(targets, targets%output >= 0), options, statistics, stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  !> The same with arrays of one kind: points(3, n) or points(n, 3).
  subroutine query_r8(self, points, half_width, distance, triangle, site, closest, gradient, barycentric, offset, &
      options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_double), intent(in), target :: points(:, :)
    real(c_double), intent(in) :: half_width
    real(c_double), intent(inout), target :: distance(:)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:)
    integer(c_int8_t), intent(inout), target, optional :: site(:)
    real(c_double), intent(inout), target, optional :: closest(:, :), gradient(:, :), barycentric(:, :)
    real(c_double), intent(inout), target, optional :: offset(:, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_target) :: targets(7)
    targets(1) = clsdf_target(CLSDF_DISTANCE, distance)
    if (present(triangle)) targets(2) = clsdf_target(CLSDF_TRIANGLE, triangle)
    if (present(site)) targets(3) = clsdf_target(CLSDF_SITE, site)
    if (present(closest)) targets(4) = clsdf_target(CLSDF_CLOSEST, closest)
    if (present(gradient)) targets(5) = clsdf_target(CLSDF_GRADIENT, gradient)
    if (present(barycentric)) targets(6) = clsdf_target(CLSDF_BARYCENTRIC, barycentric)
    if (present(offset)) targets(7) = clsdf_target(CLSDF_OFFSET, offset)
    call self%query(clsdf_array(points), half_width, pack(targets, targets%output >= 0), &
        options, statistics, stat, errmsg)
  end subroutine

  !> The same with an array for each coordinate. If these are not equally far apart in memory, they are copied.
  subroutine query_xyz_r8(self, x, y, z, half_width, distance, triangle, site, closest, gradient, barycentric, offset, &
      options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_double), intent(in), target :: x(:), y(:), z(:)
    real(c_double), intent(in) :: half_width
    real(c_double), intent(inout), target :: distance(:)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:)
    integer(c_int8_t), intent(inout), target, optional :: site(:)
    real(c_double), intent(inout), target, optional :: closest(:, :), gradient(:, :), barycentric(:, :)
    real(c_double), intent(inout), target, optional :: offset(:, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_target) :: targets(7)
    type(clsdf_array) :: points
    real(c_double), allocatable, target :: copy(:, :)
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call join(clsdf_array(x), clsdf_array(y), clsdf_array(z), points, status)
    if (status /= CLSDF_OK) then
      call clsdf_finish(status, stat, errmsg)
      return
    end if
    if (points%rank == 0) then
      allocate (copy(3, size(x, kind=c_int64_t)))
      copy(1, :) = x
      copy(2, :) = y
      copy(3, :) = z
      points = clsdf_array(copy)
    end if
    targets(1) = clsdf_target(CLSDF_DISTANCE, distance)
    if (present(triangle)) targets(2) = clsdf_target(CLSDF_TRIANGLE, triangle)
    if (present(site)) targets(3) = clsdf_target(CLSDF_SITE, site)
    if (present(closest)) targets(4) = clsdf_target(CLSDF_CLOSEST, closest)
    if (present(gradient)) targets(5) = clsdf_target(CLSDF_GRADIENT, gradient)
    if (present(barycentric)) targets(6) = clsdf_target(CLSDF_BARYCENTRIC, barycentric)
    if (present(offset)) targets(7) = clsdf_target(CLSDF_OFFSET, offset)
    call self%query(points, half_width, pack(targets, targets%output >= 0), options, statistics, stat, errmsg)
  end subroutine

  ! END

  !> Three arrays as the components of one, if they are equally far apart; else an array of rank 0.
  subroutine join(x, y, z, points, status)
    type(clsdf_array), intent(in) :: x, y, z
    type(clsdf_array), intent(out) :: points
    integer(c_int32_t), intent(inout) :: status
    integer(c_int64_t) :: apart
    if (any([y%shape(1), z%shape(1)] /= x%shape(1))) then
      status = refused('the arrays of the coordinates have the shapes '//joined(x%shape(1:1))//', '// &
          joined(y%shape(1:1))//' and '//joined(z%shape(1:1))//'; give them one shape')
      return
    end if
    apart = address(y%host) - address(x%host)
    if (address(z%host) - address(y%host) /= apart .or. apart == 0) return
    if (any([y%strides(1), z%strides(1)] /= x%strides(1))) return
    points = x
    points%rank = 2
    points%shape(1:2) = [3_c_int64_t, x%shape(1)]
    points%strides(1:2) = [apart, x%strides(1)]
  end subroutine

  !> The generalised winding number at points, in memory of the host or of the device: an integer for a closed mesh.
  subroutine winding_targets(self, points, results, options, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_array), intent(in) :: points, results
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_target) :: c(1)
    type(clsdf_c_array) :: from
    type(caller), target :: given
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call rows_for_c(points, 'points', from, status)
    ! Winding numbers have the type and the shape of distances.
    if (status == CLSDF_OK) &
        call clsdf_targets_of_samples([clsdf_target(CLSDF_DISTANCE, results)], [from%count], 1, c, status)
    if (status == CLSDF_OK) status = c_winding(self%handle, from, c(1)%array, options_for_c(given, options))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED FOR r8

  !> The same with arrays of one kind: points(3, n) or points(n, 3).
  subroutine winding_r4(self, points, results, options, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_float), intent(in), target :: points(:, :)
    real(c_float), intent(inout), target :: results(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%winding(clsdf_array(points), clsdf_array(results), options, stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  !> The same with arrays of one kind: points(3, n) or points(n, 3).
  subroutine winding_r8(self, points, results, options, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_double), intent(in), target :: points(:, :)
    real(c_double), intent(inout), target :: results(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%winding(clsdf_array(points), clsdf_array(results), options, stat, errmsg)
  end subroutine

  ! END

  !> Arrays of rank 0 are not wanted; those of t and triangles have the shape (most, n), or (n) of the first hits.
  subroutine ask_rays(self, origins, directions, most, t, triangle, counts, any_hit, hits, limit, options, statistics, &
      stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_array), intent(in) :: origins, directions, t, triangle, counts, any_hit
    integer(c_int64_t), intent(in) :: most
    integer(c_int32_t), intent(in), optional :: hits
    real(c_double), intent(in), optional :: limit
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ray_request) :: request
    type(clsdf_c_array) :: from, along
    type(caller), target :: given
    integer(c_int32_t) :: status
    status = CLSDF_OK
    request%struct_size = c_sizeof(request)
    request%most = most
    request%limit = clsdf_infinity()
    if (present(limit)) request%limit = without_limit(limit)
    if (present(hits)) request%hits = hits
    call rows_for_c(origins, 'origins', from, status)
    if (status == CLSDF_OK) call rows_for_c(directions, 'directions', along, status)
    call result_for_c(t, 't', most, request%t)
    call result_for_c(triangle, 'triangles', most, request%triangles)
    call result_for_c(counts, 'counts', 1_c_int64_t, request%counts)
    call result_for_c(any_hit, 'any_hit', 1_c_int64_t, request%any)
    if (status == CLSDF_OK) status = c_rays(self%handle, from, along, request, options_for_c(given, options), &
        statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  contains
    subroutine result_for_c(array, what, components, c)
      type(clsdf_array), intent(in) :: array
      character(*), intent(in) :: what
      integer(c_int64_t), intent(in) :: components
      type(clsdf_c_array), intent(inout) :: c
      type(clsdf_array) :: row
      if (array%rank == 0 .or. status /= CLSDF_OK) return
      row = array
      if (components == 1 .and. row%rank == 2) then
        row%rank = 1
        row%shape(1) = array%shape(2)
        row%strides(1) = array%strides(2)
      end if
      call for_c(row, what, components, [from%count], 1, c, status)
    end subroutine
  end subroutine

  !> Whether pairs of points see each other, by C.
  subroutine ask_visible(self, from, to, visible, hits, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_array), intent(in) :: from, to, visible
    integer(c_int32_t), intent(in), optional :: hits
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_array) :: first, second, seen
    type(caller), target :: given
    integer(c_int32_t) :: status, what
    status = CLSDF_OK
    what = CLSDF_WALLS
    if (present(hits)) what = hits
    call rows_for_c(from, 'first points', first, status)
    if (status == CLSDF_OK) call rows_for_c(to, 'second points', second, status)
    if (status == CLSDF_OK) call for_c(visible, 'pairs that are visible', 1_c_int64_t, [first%count], 1, seen, status)
    if (status == CLSDF_OK) status = c_visible(self%handle, first, second, what, seen, options_for_c(given, options), &
        statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED FOR r8

  !> Where rays first meet the surface. origins, directions: (3, n) or (n, 3), directions of any length. Of each ray:
  !> t(n) in lengths of the direction, infinity if nothing is met; triangle(n), 0 then; counts(n), all hits up to the
  !> limit; any_hit(n), 1 if there is one. hits: CLSDF_WALLS (default) or CLSDF_FACES. docs/rays.md.
  subroutine rays_r4(self, origins, directions, t, triangle, counts, any_hit, hits, limit, options, statistics, stat, &
      errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_float), intent(in), target :: origins(:, :), directions(:, :)
    real(c_float), intent(inout), target, optional :: t(:)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:), counts(:)
    integer(c_int8_t), intent(inout), target, optional :: any_hit(:)
    integer(c_int32_t), intent(in), optional :: hits
    real(c_double), intent(in), optional :: limit
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_array) :: results(4)
    if (present(t)) results(1) = clsdf_array(t)
    if (present(triangle)) results(2) = clsdf_array(triangle)
    if (present(counts)) results(3) = clsdf_array(counts)
    if (present(any_hit)) results(4) = clsdf_array(any_hit)
    call ask_rays(self, clsdf_array(origins), clsdf_array(directions), 1_c_int64_t, results(1), results(2), results(3), &
        results(4), hits, limit, options, statistics, stat, errmsg)
  end subroutine

  !> The first hits of each ray, as many as t(most, n) has room for, ascending; triangle(most, n).
  subroutine ray_hits_r4(self, origins, directions, t, triangle, counts, hits, limit, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_float), intent(in), target :: origins(:, :), directions(:, :)
    real(c_float), intent(inout), target :: t(:, :)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:, :), counts(:)
    integer(c_int32_t), intent(in), optional :: hits
    real(c_double), intent(in), optional :: limit
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_array) :: results(4)
    if (present(triangle)) results(2) = clsdf_array(triangle)
    if (present(counts)) results(3) = clsdf_array(counts)
    call ask_rays(self, clsdf_array(origins), clsdf_array(directions), size(t, 1, kind=c_int64_t), clsdf_array(t), &
        results(2), results(3), results(4), hits, limit, options, statistics, stat, errmsg)
  end subroutine

  !> Whether the segments between pairs of points, (3, n) or (n, 3), meet nothing: visible(n) is 1, else 0.
  subroutine visible_r4(self, from, to, visible, hits, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_float), intent(in), target :: from(:, :), to(:, :)
    integer(c_int8_t), intent(inout), target :: visible(:)
    integer(c_int32_t), intent(in), optional :: hits
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call ask_visible(self, clsdf_array(from), clsdf_array(to), clsdf_array(visible), hits, options, statistics, stat, &
        errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  !> Where rays first meet the surface. origins, directions: (3, n) or (n, 3), directions of any length. Of each ray:
  !> t(n) in lengths of the direction, infinity if nothing is met; triangle(n), 0 then; counts(n), all hits up to the
  !> limit; any_hit(n), 1 if there is one. hits: CLSDF_WALLS (default) or CLSDF_FACES. docs/rays.md.
  subroutine rays_r8(self, origins, directions, t, triangle, counts, any_hit, hits, limit, options, statistics, stat, &
      errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_double), intent(in), target :: origins(:, :), directions(:, :)
    real(c_double), intent(inout), target, optional :: t(:)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:), counts(:)
    integer(c_int8_t), intent(inout), target, optional :: any_hit(:)
    integer(c_int32_t), intent(in), optional :: hits
    real(c_double), intent(in), optional :: limit
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_array) :: results(4)
    if (present(t)) results(1) = clsdf_array(t)
    if (present(triangle)) results(2) = clsdf_array(triangle)
    if (present(counts)) results(3) = clsdf_array(counts)
    if (present(any_hit)) results(4) = clsdf_array(any_hit)
    call ask_rays(self, clsdf_array(origins), clsdf_array(directions), 1_c_int64_t, results(1), results(2), results(3), &
        results(4), hits, limit, options, statistics, stat, errmsg)
  end subroutine

  !> The first hits of each ray, as many as t(most, n) has room for, ascending; triangle(most, n).
  subroutine ray_hits_r8(self, origins, directions, t, triangle, counts, hits, limit, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_double), intent(in), target :: origins(:, :), directions(:, :)
    real(c_double), intent(inout), target :: t(:, :)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:, :), counts(:)
    integer(c_int32_t), intent(in), optional :: hits
    real(c_double), intent(in), optional :: limit
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_array) :: results(4)
    if (present(triangle)) results(2) = clsdf_array(triangle)
    if (present(counts)) results(3) = clsdf_array(counts)
    call ask_rays(self, clsdf_array(origins), clsdf_array(directions), size(t, 1, kind=c_int64_t), clsdf_array(t), &
        results(2), results(3), results(4), hits, limit, options, statistics, stat, errmsg)
  end subroutine

  !> Whether the segments between pairs of points, (3, n) or (n, 3), meet nothing: visible(n) is 1, else 0.
  subroutine visible_r8(self, from, to, visible, hits, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    real(c_double), intent(in), target :: from(:, :), to(:, :)
    integer(c_int8_t), intent(inout), target :: visible(:)
    integer(c_int32_t), intent(in), optional :: hits
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call ask_visible(self, clsdf_array(from), clsdf_array(to), clsdf_array(visible), hits, options, statistics, stat, &
        errmsg)
  end subroutine

  ! END

  !> The places (CLSDF_WITHIN ...) of boxes.
  subroutine transform_classify(self, boxes, half_width, places, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_box), intent(in) :: boxes(:)
    real(c_double), intent(in) :: half_width
    integer(c_int8_t), intent(inout) :: places(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: status
    if (size(places, kind=c_int64_t) /= size(boxes, kind=c_int64_t)) then
      status = refused('the array of the places has the shape '//joined(shape(places, c_int64_t))//'; give it '// &
          joined(shape(boxes, c_int64_t)))
    else
      status = c_classify(self%handle, boxes, size(boxes, kind=c_int64_t), without_limit(half_width), &
        places)
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! ---- Scenes ----

  !> The pose of a 4 x 4 matrix, matmul(matrix, [x, 1]), whose last row is 0, 0, 0, 1. Its rotation may be rounded to
  !> reals of 4 bytes: the nearest rotation is taken.
  subroutine pose_set_matrix(self, matrix, stat, errmsg)
    class(clsdf_pose), intent(inout) :: self
    real(c_double), intent(in) :: matrix(4, 4)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_pose) :: c
    integer(c_int32_t) :: status
    real(c_double) :: rows(16)
    rows = reshape(transpose(matrix), [16])
    status = c_pose_of_matrix(rows, c)
    if (status == CLSDF_OK) call take_pose(c, self)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine take_pose(c, pose)
    type(c_pose), intent(in) :: c
    class(clsdf_pose), intent(inout) :: pose
    pose%rotation = transpose(reshape(c%rotation, [3, 3]))
    pose%translation = c%translation
  end subroutine

  elemental function pose_for_c(pose) result(c)
    type(clsdf_pose), intent(in) :: pose
    type(c_pose) :: c
    c%rotation = reshape(transpose(pose%rotation), [9])
    c%translation = pose%translation
  end function

  function pose_or_none(pose) result(c)
    type(clsdf_pose), intent(in), optional :: pose
    type(c_pose) :: c
    c = pose_for_c(clsdf_pose())
    if (present(pose)) c = pose_for_c(pose)
  end function

  !> A scene without bodies. The host computes; points and results may be in the device's memory. surface:
  !> CLSDF_SURFACE_GIVEN, the default, or CLSDF_SURFACE_OUTER: distances of points are those to the surface of the union of
  !> the bodies, within overlaps, too.
  subroutine scene_create(self, device, kept_bytes, stat, errmsg, surface)
    class(clsdf_scene), intent(inout) :: self
    type(clsdf_device), intent(in) :: device
    integer(c_int64_t), intent(in), optional :: kept_bytes
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t), intent(in), optional :: surface
    type(c_scene_options) :: c
    call self%release()
    c%struct_size = c_sizeof(c)
    if (present(surface)) c%surface = surface
    if (present(kept_bytes)) c%kept_bytes = kept_bytes
    call clsdf_finish(c_scene_create(device%handle, c, self%handle), stat, errmsg)
  end subroutine

  !> Adds a mesh, which is copied, as body number `body`.
  subroutine scene_add(self, mesh, body, pose, sign, options, stat, errmsg)
    class(clsdf_scene), intent(inout) :: self
    type(clsdf_mesh), intent(in) :: mesh
    integer(c_int64_t), intent(out), optional :: body
    type(clsdf_pose), intent(in), optional :: pose
    integer(c_int32_t), intent(in), optional :: sign
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    integer(c_int32_t) :: rule
    integer(c_int64_t) :: number
    rule = CLSDF_SIGN_AUTOMATIC
    if (present(sign)) rule = sign
    number = 0
    call clsdf_finish(c_scene_add(self%handle, mesh%handle, rule, pose_or_none(pose), options_for_c(given, options), &
        number), stat, errmsg)
    if (present(body)) body = number
  end subroutine

  !> Adds a body that has the mesh and the sign rule of another one.
  subroutine scene_add_instance(self, of, body, pose, stat, errmsg)
    class(clsdf_scene), intent(inout) :: self
    integer(c_int64_t), intent(in) :: of
    integer(c_int64_t), intent(out), optional :: body
    type(clsdf_pose), intent(in), optional :: pose
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: number
    number = 0
    call clsdf_finish(c_scene_add_instance(self%handle, of, pose_or_none(pose), number), stat, errmsg)
    if (present(body)) body = number
  end subroutine

  !> Moves all bodies. A rotation may be rounded to reals of 4 bytes: the nearest rotation is taken.
  subroutine scene_set_poses(self, poses, stat, errmsg)
    class(clsdf_scene), intent(inout) :: self
    type(clsdf_pose), intent(in) :: poses(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_scene_set_poses(self%handle, c_null_ptr, pose_for_c(poses), size(poses, kind=c_int64_t)), &
        stat, errmsg)
  end subroutine

  !> Moves some bodies.
  subroutine scene_set_some_poses(self, bodies, poses, stat, errmsg)
    class(clsdf_scene), intent(inout) :: self
    integer(c_int64_t), intent(in) :: bodies(:)
    type(clsdf_pose), intent(in) :: poses(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t), target :: numbers(size(bodies))
    integer(c_int32_t) :: status
    numbers = bodies
    if (size(bodies) /= size(poses)) then
      status = refused('the arrays of the bodies and of the poses have the shapes '//joined(shape(bodies, c_int64_t))// &
          ' and '//joined(shape(poses, c_int64_t)))
    else if (size(bodies) == 0) then
      status = CLSDF_OK  ! a null pointer would mean all bodies
    else
      status = c_scene_set_poses(self%handle, c_loc(numbers), pose_for_c(poses), size(poses, kind=c_int64_t))
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Gives the mesh of a body, and so all its instances, new positions before their poses.
  subroutine scene_set_positions(self, body, positions, options, stat, errmsg)
    class(clsdf_scene), intent(inout) :: self
    integer(c_int64_t), intent(in) :: body
    type(clsdf_array), intent(in) :: positions
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    type(clsdf_c_array) :: c
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call rows_for_c(positions, 'positions', c, status)
    if (status == CLSDF_OK) status = c_scene_set_positions(self%handle, body, c, options_for_c(given, options))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Switches a body off, as if it were not there, or on again.
  subroutine scene_set_active(self, body, active, stat, errmsg)
    class(clsdf_scene), intent(inout) :: self
    integer(c_int64_t), intent(in) :: body
    logical, intent(in) :: active
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_scene_set_active(self%handle, body, merge(1_c_int32_t, 0_c_int32_t, active)), stat, errmsg)
  end subroutine

  function scene_size(self, stat, errmsg) result(count)
    class(clsdf_scene), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: count
    count = 0
    call clsdf_finish(c_scene_size(self%handle, count), stat, errmsg)
  end function

  function scene_is_active(self, body, stat, errmsg) result(is_active)
    class(clsdf_scene), intent(in) :: self
    integer(c_int64_t), intent(in) :: body
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    logical :: is_active
    integer(c_int32_t) :: flag
    flag = 0
    call clsdf_finish(c_scene_active(self%handle, body, flag), stat, errmsg)
    is_active = flag == 1
  end function

  !> With the rotation that is used.
  function scene_pose(self, body, stat, errmsg) result(pose)
    class(clsdf_scene), intent(in) :: self
    integer(c_int64_t), intent(in) :: body
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_pose) :: pose
    type(c_pose) :: c
    call clsdf_finish(c_scene_pose(self%handle, body, c), stat, errmsg)
    call take_pose(c, pose)
  end function

  !> The rule in use, never automatic.
  function scene_sign(self, body, stat, errmsg) result(rule)
    class(clsdf_scene), intent(in) :: self
    integer(c_int64_t), intent(in) :: body
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: rule
    rule = CLSDF_SIGN_NONE
    call clsdf_finish(c_scene_sign(self%handle, body, rule), stat, errmsg)
  end function

  !> Whether a body that is on has a sign.
  function scene_has_sign(self, stat, errmsg) result(has_sign)
    class(clsdf_scene), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    logical :: has_sign
    integer(c_int32_t) :: flag
    flag = 0
    call clsdf_finish(c_scene_has_sign(self%handle, flag), stat, errmsg)
    has_sign = flag == 1
  end function

  !> The memory that is kept of all meshes.
  !> Around the bodies that are on, where they are.
  function scene_box(self, stat, errmsg) result(box)
    class(clsdf_scene), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_box) :: box
    call clsdf_finish(c_scene_box(self%handle, box), stat, errmsg)
  end function

  function scene_memory(self, stat, errmsg) result(memory)
    class(clsdf_scene), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_kept_memory) :: memory
    memory%struct_size = c_sizeof(memory) + 1  ! calls fill it
    call clsdf_finish(c_scene_memory(self%handle, memory), stat, errmsg)
  end function

  !> The outer surface of the bodies that are on, where they are: faces are cut where bodies meet, and what lies in
  !> another body is left out. It is made anew by each call. report: counts triangles of the bodies' own outer surfaces.
  subroutine scene_outer(self, outer, report, options, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    type(clsdf_mesh), intent(inout) :: outer
    type(clsdf_outer_report), intent(out), optional :: report
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    type(clsdf_outer_report) :: found
    type(c_ptr) :: handle
    integer(c_int32_t) :: status
    found%struct_size = c_sizeof(found) + 1  ! calls fill it
    status = c_scene_outer(self%handle, options_for_c(given, options), handle, found)
    if (present(report)) report = found
    call outer%release()
    outer%handle = handle
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> As transform%compute(): the least of the bodies' signed distances, with the outputs of the body that has it, and
  !> CLSDF_BODY.
  subroutine scene_compute(self, grid, band, targets, options, statistics, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    type(clsdf_target), intent(in) :: targets(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_target) :: c(size(targets))
    type(caller), target :: given
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call clsdf_targets_of_samples(targets, grid%size, 3, c, status)
    if (status == CLSDF_OK) status = c_scene_compute(self%handle, clsdf_grid_for_c(grid), band, c, &
        size(targets, kind=c_int64_t), options_for_c(given, options), statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The same, as transform%compute_field().
  subroutine scene_compute_field(self, grid, band, field, outputs, options, statistics, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    type(clsdf_field), intent(inout) :: field
    integer(c_int32_t), intent(in), optional :: outputs(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call field%release()
    call clsdf_finish(c_scene_compute_field(self%handle, clsdf_grid_for_c(grid), band, clsdf_outputs_mask(outputs), &
        options_for_c(given, options), statistics_for_c(statistics), field%handle), stat, errmsg)
  end subroutine

  !> As transform%query(), of the body whose signed distance is the least; body(n): the body of the nearest triangle, 0
  !> beyond the half width. own(n): 1 if the distance is that of the union of the bodies, else 0.
  subroutine scene_query_targets(self, points, half_width, targets, own, options, statistics, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    type(clsdf_array), intent(in) :: points
    real(c_double), intent(in) :: half_width
    type(clsdf_target), intent(in) :: targets(:)
    integer(c_int8_t), intent(inout), target, contiguous, optional :: own(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_target) :: c(size(targets))
    type(clsdf_c_array) :: from
    type(caller), target :: given
    type(c_ptr) :: of_own
    integer(c_int32_t) :: status
    status = CLSDF_OK
    of_own = c_null_ptr
    call rows_for_c(points, 'points', from, status)
    if (status == CLSDF_OK) call clsdf_targets_of_samples(targets, [from%count], 1, c, status)
    if (present(own)) then
      call check_items('own', size(own, kind=c_int64_t), from%count, status)
      if (size(own) > 0) of_own = c_loc(own)
    end if
    if (status == CLSDF_OK) status = c_scene_query(self%handle, from, without_limit(half_width), c, &
        size(targets, kind=c_int64_t), of_own, options_for_c(given, options), statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine check_items(what, items, expected, status)
    character(*), intent(in) :: what
    integer(c_int64_t), intent(in) :: items, expected
    integer(c_int32_t), intent(inout) :: status
    if (status == CLSDF_OK .and. items /= expected) &
        status = refused('the array '//what//' has the shape '//joined([items])//'; give it '//joined([expected]))
  end subroutine

  !> The outputs of pairs of a point and a body, pairs(2, m), both from 1, by that body alone.
  subroutine scene_query_pairs(self, points, pairs, half_width, targets, options, statistics, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    type(clsdf_array), intent(in) :: points
    integer(c_int32_t), intent(in) :: pairs(:, :)
    real(c_double), intent(in) :: half_width
    type(clsdf_target), intent(in) :: targets(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_target) :: c(size(targets))
    type(clsdf_c_array) :: from
    type(caller), target :: given
    integer(c_int32_t) :: status
    integer(c_int64_t) :: count
    status = CLSDF_OK
    count = size(pairs, 2, kind=c_int64_t)
    if (size(pairs, 1) /= 2) status = refused('the array of the pairs has the shape '//joined(shape(pairs, c_int64_t))// &
        '; give it (2, m)')
    if (status == CLSDF_OK) call rows_for_c(points, 'points', from, status)
    if (status == CLSDF_OK) call clsdf_targets_of_samples(targets, [count], 1, c, status)
    if (status == CLSDF_OK) status = c_scene_query_pairs(self%handle, from, pairs, count, without_limit(half_width), c, &
        size(targets, kind=c_int64_t), options_for_c(given, options), statistics_for_c(statistics))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> 1 for each point that is inside a body, else 0. A point on the surface of a body is not inside this one.
  subroutine scene_contains(self, points, inside, options, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    type(clsdf_array), intent(in) :: points
    integer(c_int8_t), intent(inout), contiguous :: inside(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_array) :: from
    type(caller), target :: given
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call rows_for_c(points, 'points', from, status)
    call check_items('inside', size(inside, kind=c_int64_t), from%count, status)
    if (status == CLSDF_OK) status = c_scene_contains(self%handle, from, inside, options_for_c(given, options))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The sum of the bodies' winding numbers at each point, in their order.
  subroutine scene_winding(self, points, results, options, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    type(clsdf_array), intent(in) :: points
    real(c_double), intent(inout), contiguous :: results(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_array) :: from
    type(caller), target :: given
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call rows_for_c(points, 'points', from, status)
    call check_items('results', size(results, kind=c_int64_t), from%count, status)
    if (status == CLSDF_OK) status = c_scene_winding(self%handle, from, results, options_for_c(given, options))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The places of boxes: CLSDF_INSIDE one of the bodies, CLSDF_OUTSIDE all of them (CLSDF_BEYOND if no body has a sign),
  !> else CLSDF_WITHIN.
  subroutine scene_classify(self, boxes, half_width, places, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    type(clsdf_box), intent(in) :: boxes(:)
    real(c_double), intent(in) :: half_width
    integer(c_int8_t), intent(inout), contiguous :: places(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call check_items('places', size(places, kind=c_int64_t), size(boxes, kind=c_int64_t), status)
    if (status == CLSDF_OK) &
        status = c_scene_classify(self%handle, boxes, size(boxes, kind=c_int64_t), without_limit(half_width), places)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED FOR r8 closest

  !> The same with arrays of one kind: points(3, n) or points(n, 3).
  subroutine scene_query_r4(self, points, half_width, distance, triangle, site, offset, gradient, barycentric, &
      body, own, options, statistics, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    real(c_float), intent(in), target :: points(:, :)
    real(c_double), intent(in) :: half_width
    real(c_float), intent(inout), target :: distance(:)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:)
    integer(c_int8_t), intent(inout), target, optional :: site(:)
    real(c_float), intent(inout), target, optional :: offset(:, :), gradient(:, :), barycentric(:, :)
    integer(c_int32_t), intent(inout), target, optional :: body(:)
    integer(c_int8_t), intent(inout), target, contiguous, optional :: own(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_target) :: targets(8)
    targets(1) = clsdf_target(CLSDF_DISTANCE, distance)
    if (present(triangle)) targets(2) = clsdf_target(CLSDF_TRIANGLE, triangle)
    if (present(site)) targets(3) = clsdf_target(CLSDF_SITE, site)
    if (present(offset)) targets(4) = clsdf_target(CLSDF_OFFSET, offset)
    if (present(gradient)) targets(5) = clsdf_target(CLSDF_GRADIENT, gradient)
    if (present(barycentric)) targets(6) = clsdf_target(CLSDF_BARYCENTRIC, barycentric)
    if (present(body)) targets(8) = clsdf_target(CLSDF_BODY, body)
    call self%query(clsdf_array(points), half_width, pack(targets, targets%output >= 0), own, &
        options, statistics, stat, errmsg)
  end subroutine

  !> The distances of pairs, of the points' kind.
  subroutine scene_query_pairs_r4(self, points, pairs, half_width, distance, options, statistics, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    real(c_float), intent(in), target :: points(:, :)
    integer(c_int32_t), intent(in) :: pairs(:, :)
    real(c_double), intent(in) :: half_width
    real(c_float), intent(inout), target :: distance(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%query_pairs(clsdf_array(points), pairs, half_width, [clsdf_target(CLSDF_DISTANCE, distance)], options, &
        statistics, stat, errmsg)
  end subroutine

  subroutine scene_contains_r4(self, points, inside, options, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    real(c_float), intent(in), target :: points(:, :)
    integer(c_int8_t), intent(inout), contiguous :: inside(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%contains(clsdf_array(points), inside, options, stat, errmsg)
  end subroutine

  subroutine scene_winding_r4(self, points, results, options, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    real(c_float), intent(in), target :: points(:, :)
    real(c_double), intent(inout), contiguous :: results(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%winding(clsdf_array(points), results, options, stat, errmsg)
  end subroutine

  subroutine scene_set_positions_r4(self, body, positions, options, stat, errmsg)
    class(clsdf_scene), intent(inout) :: self
    integer(c_int64_t), intent(in) :: body
    real(c_float), intent(in), target :: positions(:, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%set_positions(body, clsdf_array(positions), options, stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  !> The same with arrays of one kind: points(3, n) or points(n, 3).
  subroutine scene_query_r8(self, points, half_width, distance, triangle, site, closest, gradient, barycentric, offset, &
      body, own, options, statistics, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    real(c_double), intent(in), target :: points(:, :)
    real(c_double), intent(in) :: half_width
    real(c_double), intent(inout), target :: distance(:)
    integer(c_int32_t), intent(inout), target, optional :: triangle(:)
    integer(c_int8_t), intent(inout), target, optional :: site(:)
    real(c_double), intent(inout), target, optional :: closest(:, :), gradient(:, :), barycentric(:, :)
    real(c_double), intent(inout), target, optional :: offset(:, :)
    integer(c_int32_t), intent(inout), target, optional :: body(:)
    integer(c_int8_t), intent(inout), target, contiguous, optional :: own(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_target) :: targets(8)
    targets(1) = clsdf_target(CLSDF_DISTANCE, distance)
    if (present(triangle)) targets(2) = clsdf_target(CLSDF_TRIANGLE, triangle)
    if (present(site)) targets(3) = clsdf_target(CLSDF_SITE, site)
    if (present(closest)) targets(4) = clsdf_target(CLSDF_CLOSEST, closest)
    if (present(gradient)) targets(5) = clsdf_target(CLSDF_GRADIENT, gradient)
    if (present(barycentric)) targets(6) = clsdf_target(CLSDF_BARYCENTRIC, barycentric)
    if (present(offset)) targets(7) = clsdf_target(CLSDF_OFFSET, offset)
    if (present(body)) targets(8) = clsdf_target(CLSDF_BODY, body)
    call self%query(clsdf_array(points), half_width, pack(targets, targets%output >= 0), own, &
        options, statistics, stat, errmsg)
  end subroutine

  !> The distances of pairs, of the points' kind.
  subroutine scene_query_pairs_r8(self, points, pairs, half_width, distance, options, statistics, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    real(c_double), intent(in), target :: points(:, :)
    integer(c_int32_t), intent(in) :: pairs(:, :)
    real(c_double), intent(in) :: half_width
    real(c_double), intent(inout), target :: distance(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%query_pairs(clsdf_array(points), pairs, half_width, [clsdf_target(CLSDF_DISTANCE, distance)], options, &
        statistics, stat, errmsg)
  end subroutine

  subroutine scene_contains_r8(self, points, inside, options, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    real(c_double), intent(in), target :: points(:, :)
    integer(c_int8_t), intent(inout), contiguous :: inside(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%contains(clsdf_array(points), inside, options, stat, errmsg)
  end subroutine

  subroutine scene_winding_r8(self, points, results, options, stat, errmsg)
    class(clsdf_scene), intent(in) :: self
    real(c_double), intent(in), target :: points(:, :)
    real(c_double), intent(inout), contiguous :: results(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%winding(clsdf_array(points), results, options, stat, errmsg)
  end subroutine

  subroutine scene_set_positions_r8(self, body, positions, options, stat, errmsg)
    class(clsdf_scene), intent(inout) :: self
    integer(c_int64_t), intent(in) :: body
    real(c_double), intent(in), target :: positions(:, :)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call self%set_positions(body, clsdf_array(positions), options, stat, errmsg)
  end subroutine

  ! END

  !> The directions (3, Q) of a stencil, 'D3Q15', 'D3Q19' or 'D3Q27', in the order of a code: 'OpenLB', 'waLBerla',
  !> 'lbmpy', 'Palabos' or 'XLB'.
  subroutine clsdf_stencil(name, code, directions, stat, errmsg)
    character(*), intent(in) :: name, code
    integer(c_int32_t), allocatable, intent(out) :: directions(:, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: all(3, 27), status
    integer(c_int64_t) :: count
    count = 0
    status = c_stencil(trim(name)//c_null_char, trim(code)//c_null_char, all, count)
    directions = all(:, :count)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  pure function link_options(hits, with_between) result(c)
    integer(c_int32_t), intent(in), optional :: hits
    logical, intent(in), optional :: with_between
    type(c_link_options) :: c
    if (present(hits)) c%hits = hits
    if (present(with_between)) c%with_between = merge(1, 0, with_between)
  end function

  !> How many links links() would give.
  subroutine transform_count_links(self, grid, directions, count, hits, with_between, options, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    integer(c_int32_t), intent(in), contiguous :: directions(:, :)  !< (3, Q)
    integer(c_int64_t), intent(out) :: count
    integer(c_int32_t), intent(in), optional :: hits
    logical, intent(in), optional :: with_between
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    integer(c_int32_t) :: status
    count = 0
    if (size(directions, 1) /= 3) then
      status = refused('the array of the directions has the shape '//joined(shape(directions, c_int64_t))//'; give it (3, Q)')
    else
      status = c_count_links(self%handle, clsdf_grid_for_c(grid), directions, size(directions, 2, c_int64_t), &
          link_options(hits, with_between), options_for_c(given, options), count)
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The links of a grid that meet the surface: one if and only if its ends are on different sides. hits: CLSDF_WALLS or
  !> CLSDF_FACES, all faces as given. with_between: also links with both ends outside and a body between them.
  subroutine transform_links(self, grid, directions, links, hits, with_between, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    integer(c_int32_t), intent(in), contiguous :: directions(:, :)  !< (3, Q)
    type(clsdf_links), intent(out), target :: links
    integer(c_int32_t), intent(in), optional :: hits
    logical, intent(in), optional :: with_between
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    type(c_link_arrays) :: c
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    if (size(directions, 1) /= 3) then
      status = refused('the array of the directions has the shape '//joined(shape(directions, c_int64_t))//'; give it (3, Q)')
    else
      status = c_count_links(self%handle, clsdf_grid_for_c(grid), directions, size(directions, 2, c_int64_t), &
          link_options(hits, with_between), options_for_c(given, options), count)
    end if
    if (status == CLSDF_OK) then
      allocate (links%samples(3, count), links%directions(count), links%q(count), links%triangles(count), &
          links%counts(count), links%flags(count), links%inside(grid%size(1), grid%size(2), grid%size(3)))
      c%room = count
      c%samples = c_loc(links%samples)
      c%directions = c_loc(links%directions)
      c%q = c_loc(links%q)
      c%triangles = c_loc(links%triangles)
      c%counts = c_loc(links%counts)
      c%flags = c_loc(links%flags)
      c%inside = c_loc(links%inside)
      status = c_links(self%handle, clsdf_grid_for_c(grid), directions, size(directions, 2, c_int64_t), &
          link_options(hits, with_between), c, options_for_c(given, options), statistics_for_c(statistics), count)
      if (status == CLSDF_OK) links%samples = links%samples + 1
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The links of a grid of any size, slab by slab in the order of z: the rows one after another are those of links().
  subroutine transform_link_slabs(self, grid, directions, sink, hits, with_between, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    integer(c_int32_t), intent(in), contiguous :: directions(:, :)  !< (3, Q)
    class(clsdf_link_sink), intent(inout), target :: sink
    integer(c_int32_t), intent(in), optional :: hits
    logical, intent(in), optional :: with_between
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(link_taker), target :: taker
    type(caller), target :: given
    integer(c_int32_t) :: status
    taker%sink => sink
    if (size(directions, 1) /= 3) then
      status = refused('the array of the directions has the shape '//joined(shape(directions, c_int64_t))//'; give it (3, Q)')
    else
      status = c_link_slabs(self%handle, clsdf_grid_for_c(grid), directions, size(directions, 2, c_int64_t), &
          link_options(hits, with_between), c_funloc(on_link_slab), c_loc(taker), options_for_c(given, options), &
          statistics_for_c(statistics))
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED FOR r8

  !> q by sample and direction, dense(nx, ny, nz, Q); -1 where there is no link. inside(nx, ny, nz): 1 or 0.
  subroutine links_dense_r4(self, grid, directions, dense, inside, hits, with_between, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    integer(c_int32_t), intent(in), contiguous :: directions(:, :)  !< (3, Q)
    real(c_float), intent(inout), target, contiguous :: dense(:, :, :, :)
    integer(c_int8_t), intent(inout), target, contiguous, optional :: inside(:, :, :)
    integer(c_int32_t), intent(in), optional :: hits
    logical, intent(in), optional :: with_between
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    type(c_link_arrays) :: c
    integer(c_int64_t) :: count, expected(4)
    integer(c_int32_t) :: status
    status = CLSDF_OK
    expected = [grid%size, size(directions, 2, c_int64_t)]
    if (size(directions, 1) /= 3) then
      status = refused('the array of the directions has the shape '//joined(shape(directions, c_int64_t))//'; give it (3, Q)')
    else if (any(shape(dense, c_int64_t) /= expected)) then
      status = refused('the dense array has the shape '//joined(shape(dense, c_int64_t))//'; give it '//joined(expected))
    else if (present(inside)) then
      if (any(shape(inside, c_int64_t) /= grid%size)) status = refused('the array of inside has the shape '// &
          joined(shape(inside, c_int64_t))//'; give it '//joined(grid%size))
      if (size(inside) > 0) c%inside = c_loc(inside)
    end if
    if (status == CLSDF_OK) then
      if (kind(dense) == c_double) then
        c%dense = c_loc(dense)
      else
        c%dense_floats = c_loc(dense)
      end if
      status = c_links(self%handle, clsdf_grid_for_c(grid), directions, size(directions, 2, c_int64_t), &
          link_options(hits, with_between), c, options_for_c(given, options), statistics_for_c(statistics), count)
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  !> q by sample and direction, dense(nx, ny, nz, Q); -1 where there is no link. inside(nx, ny, nz): 1 or 0.
  subroutine links_dense_r8(self, grid, directions, dense, inside, hits, with_between, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    integer(c_int32_t), intent(in), contiguous :: directions(:, :)  !< (3, Q)
    real(c_double), intent(inout), target, contiguous :: dense(:, :, :, :)
    integer(c_int8_t), intent(inout), target, contiguous, optional :: inside(:, :, :)
    integer(c_int32_t), intent(in), optional :: hits
    logical, intent(in), optional :: with_between
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    type(c_link_arrays) :: c
    integer(c_int64_t) :: count, expected(4)
    integer(c_int32_t) :: status
    status = CLSDF_OK
    expected = [grid%size, size(directions, 2, c_int64_t)]
    if (size(directions, 1) /= 3) then
      status = refused('the array of the directions has the shape '//joined(shape(directions, c_int64_t))//'; give it (3, Q)')
    else if (any(shape(dense, c_int64_t) /= expected)) then
      status = refused('the dense array has the shape '//joined(shape(dense, c_int64_t))//'; give it '//joined(expected))
    else if (present(inside)) then
      if (any(shape(inside, c_int64_t) /= grid%size)) status = refused('the array of inside has the shape '// &
          joined(shape(inside, c_int64_t))//'; give it '//joined(grid%size))
      if (size(inside) > 0) c%inside = c_loc(inside)
    end if
    if (status == CLSDF_OK) then
      if (kind(dense) == c_double) then
        c%dense = c_loc(dense)
      else
        c%dense_floats = c_loc(dense)
      end if
      status = c_links(self%handle, clsdf_grid_for_c(grid), directions, size(directions, 2, c_int64_t), &
          link_options(hits, with_between), c, options_for_c(given, options), statistics_for_c(statistics), count)
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! END

  !> Where the edges of a grid between neighbouring samples meet walls, along x, y and z. with_counts: their numbers, too.
  subroutine transform_crossings(self, grid, crossings, inside, with_counts, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_crossings), intent(out), target :: crossings(3)
    integer(c_int8_t), allocatable, intent(out), target, optional :: inside(:, :, :)  !< of each sample: 1 or 0
    logical, intent(in), optional :: with_counts
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    type(c_crossing_arrays) :: c
    integer(c_int64_t) :: edges(3)
    logical :: counted
    integer :: axis
    counted = .false.
    if (present(with_counts)) counted = with_counts
    do axis = 1, 3
      edges = grid%size
      edges(axis) = edges(axis) - 1
      allocate (crossings(axis)%coordinates(edges(1), edges(2), edges(3)), crossings(axis)%triangles(edges(1), edges(2), edges(3)))
      c%coordinates(axis) = c_loc(crossings(axis)%coordinates)
      c%triangles(axis) = c_loc(crossings(axis)%triangles)
      if (.not. counted) cycle
      allocate (crossings(axis)%counts(edges(1), edges(2), edges(3)))
      c%counts(axis) = c_loc(crossings(axis)%counts)
    end do
    if (present(inside)) then
      allocate (inside(grid%size(1), grid%size(2), grid%size(3)))
      c%inside = c_loc(inside)
    end if
    call clsdf_finish(c_crossings(self%handle, clsdf_grid_for_c(grid), c, options_for_c(given, options), &
        statistics_for_c(statistics)), stat, errmsg)
  end subroutine

  !> Of the vertices in use, at their present positions.
  function transform_box(self, stat, errmsg) result(box)
    class(clsdf_transform), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_box) :: box
    call clsdf_finish(c_transform_box(self%handle, box), stat, errmsg)
  end function

  function transform_topology(self, stat, errmsg) result(topology)
    class(clsdf_transform), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_topology) :: topology
    type(c_topology) :: c
    c%struct_size = c_sizeof(c) + 1  ! calls fill it
    call clsdf_finish(c_transform_topology(self%handle, c), stat, errmsg)
    call take_topology(c, topology)
  end function

  !> The rule in use, never automatic.
  function transform_sign(self, stat, errmsg) result(rule)
    class(clsdf_transform), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: rule
    call clsdf_finish(c_transform_sign(self%handle, rule), stat, errmsg)
  end function

  function transform_index_base(self, stat, errmsg) result(index_base)
    class(clsdf_transform), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: index_base
    call clsdf_finish(c_transform_index_base(self%handle, index_base), stat, errmsg)
  end function

  subroutine transform_device(self, device, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_device), intent(inout) :: device
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call device%release()
    call clsdf_finish(c_transform_device(self%handle, device%handle), stat, errmsg)
  end subroutine

  function transform_memory(self, stat, errmsg) result(memory)
    class(clsdf_transform), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_kept_memory) :: memory
    memory%struct_size = c_sizeof(memory) + 1  ! calls fill it
    call clsdf_finish(c_transform_memory(self%handle, memory), stat, errmsg)
  end function

  !> Builds and tests the programs that such a field needs. Computations do it by themselves.
  subroutine transform_compile(self, grid, band, outputs, options, statistics, stat, errmsg)
    class(clsdf_transform), intent(in) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    integer(c_int32_t), intent(in), optional :: outputs(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    type(clsdf_statistics), intent(inout), target, optional :: statistics
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call clsdf_finish(c_transform_compile(self%handle, clsdf_grid_for_c(grid), band, clsdf_outputs_mask(outputs), &
        options_for_c(given, options), statistics_for_c(statistics)), stat, errmsg)
  end subroutine

  ! ---- Plans ----

  !> A plan of one grid, without targets: enqueue_to() gives them, packed.
  subroutine plan_create_grid(self, transform, grid, band, outputs, options, stat, errmsg)
    class(clsdf_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    integer(c_int32_t), intent(in), optional :: outputs(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call self%release()
    call clsdf_finish(c_plan_create(transform%handle, clsdf_grid_for_c(grid), band, clsdf_outputs_mask(outputs), &
        options_for_c(given, options), self%handle), stat, errmsg)
  end subroutine

  !> A plan of boxes, into buffers of the device's context, which must outlive it.
  subroutine plan_create_requests(self, transform, requests, options, stat, errmsg)
    class(clsdf_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_request), intent(in) :: requests(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(request_list), target :: c
    type(caller), target :: given
    integer(c_int32_t) :: status
    call self%release()
    call requests_for_c(requests, c, status)
    if (status == CLSDF_OK) status = c_plan_create_requests(transform%handle, c%items, size(requests, kind=c_int64_t), &
        options_for_c(given, options), self%handle)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine plan_create_blocks(self, transform, blocks, options, stat, errmsg)
    class(clsdf_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_block_set), intent(in) :: blocks
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(block_list), target :: c
    type(caller), target :: given
    integer(c_int32_t) :: status
    call self%release()
    call blocks_for_c(blocks, c, status)
    if (status == CLSDF_OK) status = c_plan_create_blocks(transform%handle, c%c, options_for_c(given, options), self%handle)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The device memory of such a plan, which is made and given back.
  function plan_bytes_requests(transform, requests, options, stat, errmsg) result(bytes)
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_request), intent(in) :: requests(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: bytes
    type(request_list), target :: c
    type(caller), target :: given
    integer(c_int32_t) :: status
    bytes = 0
    call requests_for_c(requests, c, status)
    if (status == CLSDF_OK) status = c_plan_bytes_requests(transform%handle, c%items, size(requests, kind=c_int64_t), &
        options_for_c(given, options), bytes)
    call clsdf_finish(status, stat, errmsg)
  end function

  function plan_bytes_blocks(transform, blocks, options, stat, errmsg) result(bytes)
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_block_set), intent(in) :: blocks
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: bytes
    type(block_list), target :: c
    type(caller), target :: given
    integer(c_int32_t) :: status
    bytes = 0
    call blocks_for_c(blocks, c, status)
    if (status == CLSDF_OK) status = c_plan_bytes_blocks(transform%handle, c%c, options_for_c(given, options), bytes)
    call clsdf_finish(status, stat, errmsg)
  end function

  !> Enqueues all requests on a cl_command_queue (c_null_ptr: the device's own) after the events. Never blocks. `done` gets
  !> the cl_event of the end, which the caller releases.
  subroutine plan_enqueue(self, queue, wait_list, done, stat, errmsg)
    class(clsdf_plan), intent(inout) :: self
    type(c_ptr), intent(in), optional :: queue
    type(c_ptr), intent(in), target, optional :: wait_list(:)
    type(c_ptr), intent(out), target, optional :: done
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ptr), allocatable, target :: events(:)
    call list_events(wait_list, events)
    call clsdf_finish(c_plan_enqueue(self%handle, queue_of(queue), first_of(events), size(events, kind=c_int64_t), &
        place_of(done)), stat, errmsg)
  end subroutine

  !> One run of a plan of one grid or request into other targets.
  subroutine plan_enqueue_to(self, targets, queue, wait_list, done, stat, errmsg)
    class(clsdf_plan), intent(inout) :: self
    type(clsdf_target), intent(in) :: targets(:)
    type(c_ptr), intent(in), optional :: queue
    type(c_ptr), intent(in), target, optional :: wait_list(:)
    type(c_ptr), intent(out), target, optional :: done
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_request) :: request(1)
    request(1)%targets = targets
    call self%enqueue_to(request, queue, wait_list, done, stat, errmsg)
  end subroutine

  !> One run into the targets of these requests, one for each request of the plan; their grids and bands do not count.
  subroutine plan_enqueue_to_many(self, requests, queue, wait_list, done, stat, errmsg)
    class(clsdf_plan), intent(inout) :: self
    type(clsdf_request), intent(in) :: requests(:)
    type(c_ptr), intent(in), optional :: queue
    type(c_ptr), intent(in), target, optional :: wait_list(:)
    type(c_ptr), intent(out), target, optional :: done
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ptr), allocatable, target :: events(:)
    type(request_list), target :: c
    type(c_targets) :: lists(size(requests))
    integer(c_int32_t) :: status
    call list_events(wait_list, events)
    call requests_for_c(requests, c, status)
    if (status == CLSDF_OK) then
      lists = c%items%targets
      status = c_plan_enqueue_to(self%handle, queue_of(queue), lists, size(lists, kind=c_int64_t), first_of(events), &
          size(events, kind=c_int64_t), place_of(done))
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  function queue_of(queue) result(handle)
    type(c_ptr), intent(in), optional :: queue
    type(c_ptr) :: handle
    handle = c_null_ptr
    if (present(queue)) handle = queue
  end function

  subroutine list_events(wait_list, events)
    type(c_ptr), intent(in), optional :: wait_list(:)
    type(c_ptr), allocatable, intent(out) :: events(:)
    allocate (events(0))
    if (present(wait_list)) events = wait_list
  end subroutine

  function first_of(events) result(pointer)
    type(c_ptr), intent(in), target :: events(:)
    type(c_ptr) :: pointer
    pointer = c_null_ptr
    if (size(events) > 0) pointer = c_loc(events(1))
  end function

  function place_of(done) result(pointer)
    type(c_ptr), intent(in), target, optional :: done
    type(c_ptr) :: pointer
    pointer = c_null_ptr
    if (present(done)) pointer = c_loc(done)
  end function

  !> Prepares the next runs for the present positions of the transform. Blocks.
  subroutine plan_update(self, transform, options, stat, errmsg)
    class(clsdf_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call clsdf_finish(c_plan_update(self%handle, transform%handle, options_for_c(given, options)), stat, errmsg)
  end subroutine

  !> The same with a grid for each request.
  subroutine plan_update_grids(self, transform, grids, options, stat, errmsg)
    class(clsdf_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_grid), intent(in) :: grids(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_grid) :: c(size(grids))
    type(caller), target :: given
    integer :: i
    do i = 1, size(grids)
      c(i) = clsdf_grid_for_c(grids(i))
    end do
    call clsdf_finish(c_plan_update_grids(self%handle, transform%handle, c, size(grids, kind=c_int64_t), &
        options_for_c(given, options)), stat, errmsg)
  end subroutine

  !> The same with other requests, any number.
  subroutine plan_update_requests(self, transform, requests, options, stat, errmsg)
    class(clsdf_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_request), intent(in) :: requests(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(request_list), target :: c
    type(caller), target :: given
    integer(c_int32_t) :: status
    call requests_for_c(requests, c, status)
    if (status == CLSDF_OK) status = c_plan_update_requests(self%handle, transform%handle, c%items, &
        size(requests, kind=c_int64_t), options_for_c(given, options))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine plan_update_blocks(self, transform, blocks, options, stat, errmsg)
    class(clsdf_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_block_set), intent(in) :: blocks
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(block_list), target :: c
    type(caller), target :: given
    integer(c_int32_t) :: status
    call blocks_for_c(blocks, c, status)
    if (status == CLSDF_OK) status = c_plan_update_blocks(self%handle, transform%handle, c%c, &
        options_for_c(given, options))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> A plan for at most `count` points at a time. Blocks.
  subroutine point_plan_create(self, transform, count, half_width, outputs, options, stat, errmsg)
    class(clsdf_point_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    integer(c_int64_t), intent(in) :: count
    real(c_double), intent(in) :: half_width
    integer(c_int32_t), intent(in), optional :: outputs(:)
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call self%release()
    call clsdf_finish(c_point_plan_create(transform%handle, count, without_limit(half_width), &
        clsdf_outputs_mask(outputs), options_for_c(given, options), self%handle), stat, errmsg)
  end subroutine

  !> Enqueues the search for points on a cl_command_queue (c_null_ptr: the device's own) after the events. Never blocks.
  !> Points, targets and `outcome` are buffers: clsdf_array(buffer, CLSDF_FLOAT64, count=n). `outcome` gets a byte of each
  !> point: CLSDF_FOUND, or why it has no distance. `done` gets the cl_event of the end, which the caller releases.
  subroutine point_plan_enqueue(self, points, targets, outcome, queue, wait_list, done, stat, errmsg)
    class(clsdf_point_plan), intent(inout) :: self
    type(clsdf_array), intent(in) :: points
    type(clsdf_target), intent(in) :: targets(:)
    type(clsdf_array), intent(in), optional :: outcome
    type(c_ptr), intent(in), optional :: queue
    type(c_ptr), intent(in), target, optional :: wait_list(:)
    type(c_ptr), intent(out), target, optional :: done
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ptr), allocatable, target :: events(:)
    type(clsdf_c_target) :: c(size(targets))
    type(clsdf_c_target), target :: of_outcome(1)
    type(clsdf_c_array) :: from
    type(c_ptr) :: outcome_for_c
    integer(c_int32_t) :: status
    status = CLSDF_OK
    outcome_for_c = c_null_ptr
    call list_events(wait_list, events)
    call rows_for_c(points, 'points', from, status)
    if (status == CLSDF_OK) call clsdf_targets_of_samples(targets, [from%count], 1, c, status)
    if (status == CLSDF_OK .and. present(outcome)) then
      ! A byte of each point, as a site is.
      call clsdf_targets_of_samples([clsdf_target(CLSDF_SITE, outcome)], [from%count], 1, of_outcome, status)
      outcome_for_c = c_loc(of_outcome(1)%array)
    end if
    if (status == CLSDF_OK) status = c_point_plan_enqueue(self%handle, queue_of(queue), from, c, &
        size(c, kind=c_int64_t), outcome_for_c, first_of(events), size(events, kind=c_int64_t), place_of(done))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Prepares the next runs for the present positions of the transform. Blocks.
  subroutine point_plan_update(self, transform, options, stat, errmsg)
    class(clsdf_point_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call clsdf_finish(c_point_plan_update(self%handle, transform%handle, options_for_c(given, options)), stat, errmsg)
  end subroutine

  !> The most points of a run.
  function point_plan_count(self, stat, errmsg) result(count)
    class(clsdf_point_plan), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: count
    call clsdf_finish(c_point_plan_count(self%handle, count), stat, errmsg)
  end function

  function point_plan_sign(self, stat, errmsg) result(rule)
    class(clsdf_point_plan), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: rule
    call clsdf_finish(c_point_plan_sign(self%handle, rule), stat, errmsg)
  end function

  !> Of making or updating it.
  function point_plan_statistics(self, stat, errmsg) result(statistics)
    class(clsdf_point_plan), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_statistics), target :: statistics
    call clsdf_finish(c_point_plan_statistics(self%handle, statistics_for_c(statistics)), stat, errmsg)
  end function

  function plan_sign(self, stat, errmsg) result(rule)
    class(clsdf_plan), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: rule
    call clsdf_finish(c_plan_sign(self%handle, rule), stat, errmsg)
  end function

  !> Of making or updating it.
  function plan_statistics(self, stat, errmsg) result(statistics)
    class(clsdf_plan), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_statistics), target :: statistics
    call clsdf_finish(c_plan_statistics(self%handle, statistics_for_c(statistics)), stat, errmsg)
  end function

  function plan_request_count(self, stat, errmsg) result(count)
    class(clsdf_plan), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t) :: count
    call clsdf_finish(c_plan_request_count(self%handle, count), stat, errmsg)
  end function

  !> Links of a grid in directions (3, Q), whose runs write at most `room` rows.
  subroutine link_plan_create(self, transform, grid, directions, room, hits, with_between, options, stat, errmsg)
    class(clsdf_link_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_grid), intent(in) :: grid
    integer(c_int32_t), intent(in), contiguous :: directions(:, :)
    integer(c_int64_t), intent(in) :: room
    integer(c_int32_t), intent(in), optional :: hits
    logical, intent(in), optional :: with_between
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    integer(c_int32_t) :: status
    call self%release()
    if (size(directions, 1) /= 3) then
      status = refused('the array of the directions has the shape '//joined(shape(directions, c_int64_t))//'; give it (3, Q)')
    else
      status = c_link_plan_create(transform%handle, clsdf_grid_for_c(grid), directions, size(directions, 2, c_int64_t), &
          room, link_options(hits, with_between), options_for_c(given, options), self%handle)
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Enqueues the links into these buffers, as plan%enqueue() does. Reads nothing back.
  subroutine link_plan_enqueue(self, buffers, queue, wait_list, done, stat, errmsg)
    class(clsdf_link_plan), intent(inout) :: self
    type(clsdf_link_buffers), intent(in) :: buffers
    type(c_ptr), intent(in), optional :: queue
    type(c_ptr), intent(in), target, optional :: wait_list(:)
    type(c_ptr), intent(out), target, optional :: done
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_ptr), allocatable, target :: events(:)
    type(clsdf_c_grid) :: grid
    type(c_link_buffers) :: c
    integer(c_int64_t) :: room
    integer(c_int32_t) :: status
    call list_events(wait_list, events)
    c%struct_size = c_sizeof(c)
    c%room = buffers%room
    c%count = buffers%count
    c%count_offset = buffers%count_offset
    status = c_link_plan_grid(self%handle, grid, room)
    call buffer_for_c(buffers%samples, 'samples', 3_c_int64_t, buffers%room, c%samples, status)
    call buffer_for_c(buffers%directions, 'directions', 1_c_int64_t, buffers%room, c%directions, status)
    call buffer_for_c(buffers%q, 'q', 1_c_int64_t, buffers%room, c%q, status)
    call buffer_for_c(buffers%triangles, 'triangles', 1_c_int64_t, buffers%room, c%triangles, status)
    call buffer_for_c(buffers%counts, 'counts', 1_c_int64_t, buffers%room, c%counts, status)
    call buffer_for_c(buffers%flags, 'flags', 1_c_int64_t, buffers%room, c%flags, status)
    call buffer_for_c(buffers%inside, 'inside', 1_c_int64_t, product(grid%size), c%inside, status)
    call buffer_for_c(buffers%dense, 'dense fields', 1_c_int64_t, product(grid%size), c%dense, status)
    if (status == CLSDF_OK) status = c_link_plan_enqueue(self%handle, queue_of(queue), c, first_of(events), &
        size(events, kind=c_int64_t), place_of(done))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! Of an array without a buffer nothing is set.
  subroutine buffer_for_c(array, what, components, items, c, status)
    type(clsdf_array), intent(in) :: array
    character(*), intent(in) :: what
    integer(c_int64_t), intent(in) :: components, items
    type(clsdf_c_array), intent(inout) :: c
    integer(c_int32_t), intent(inout) :: status
    if (status /= CLSDF_OK .or. .not. (c_associated(array%device) .or. array%rank > 0)) return
    call for_c(array, what, components, [items], 1, c, status)
  end subroutine

  !> Prepares the next runs for the present positions of the transform. Blocks. After an error the plan is as it was.
  subroutine link_plan_update(self, transform, options, stat, errmsg)
    class(clsdf_link_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call clsdf_finish(c_link_plan_update(self%handle, transform%handle, options_for_c(given, options)), stat, errmsg)
  end subroutine

  !> The same with another grid and other room.
  subroutine link_plan_update_grid(self, transform, grid, room, options, stat, errmsg)
    class(clsdf_link_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_grid), intent(in) :: grid
    integer(c_int64_t), intent(in) :: room
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call clsdf_finish(c_link_plan_update_grid(self%handle, transform%handle, clsdf_grid_for_c(grid), room, &
        options_for_c(given, options)), stat, errmsg)
  end subroutine

  function link_plan_sign(self, stat, errmsg) result(rule)
    class(clsdf_link_plan), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: rule
    call clsdf_finish(c_link_plan_sign(self%handle, rule), stat, errmsg)
  end function

  !> Of making or updating it.
  function link_plan_statistics(self, stat, errmsg) result(statistics)
    class(clsdf_link_plan), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_statistics), target :: statistics
    call clsdf_finish(c_link_plan_statistics(self%handle, statistics_for_c(statistics)), stat, errmsg)
  end function

  !> Its grid and the most rows of a run.
  subroutine link_plan_grid(self, grid, room, stat, errmsg)
    class(clsdf_link_plan), intent(in) :: self
    type(clsdf_grid), intent(inout) :: grid
    integer(c_int64_t), intent(out) :: room
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_grid) :: c
    integer(c_int32_t) :: status
    status = c_link_plan_grid(self%handle, c, room)
    if (status == CLSDF_OK) call take_grid(c, grid)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> A sparse field whose runs have room for so many bricks and runs of bricks inside.
  subroutine sparse_plan_create(self, transform, request, room, options, stat, errmsg)
    class(clsdf_sparse_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_sparse_request), intent(in) :: request
    type(clsdf_sparse_counts), intent(in) :: room
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call self%release()
    call clsdf_finish(c_sparse_plan_create(transform%handle, sparse_request_for_c(request), room, &
        options_for_c(given, options), self%handle), stat, errmsg)
  end subroutine

  !> Enqueues the field into these buffers, as plan%enqueue() does. Reads nothing back.
  subroutine sparse_plan_enqueue(self, buffers, queue, wait_list, done, stat, errmsg)
    class(clsdf_sparse_plan), intent(inout) :: self
    type(clsdf_sparse_buffers), intent(in) :: buffers
    type(c_ptr), intent(in), optional :: queue
    type(c_ptr), intent(in), target, optional :: wait_list(:)
    type(c_ptr), intent(out), target, optional :: done
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_target), allocatable :: given(:)
    type(clsdf_c_target), allocatable, target :: values(:)
    type(c_ptr), allocatable, target :: events(:)
    type(c_sparse_request) :: request
    type(clsdf_sparse_counts) :: room
    type(c_sparse_buffers) :: c
    integer(c_int32_t) :: status
    call list_events(wait_list, events)
    allocate (given(0))
    if (allocated(buffers%values)) given = buffers%values
    allocate (values(size(given)))
    status = c_sparse_plan_request(self%handle, request, room)
    if (status == CLSDF_OK) call clsdf_targets_of_samples(given, [8_c_int64_t, 8_c_int64_t, 8_c_int64_t, room%bricks], 3, &
        values, status)
    if (status == CLSDF_OK) then
      c%struct_size = c_sizeof(c)
      c%counts = buffers%counts
      c%counts_offset = buffers%counts_offset
      c%bricks = buffers%bricks
      c%bricks_offset = buffers%bricks_offset
      c%inside = buffers%inside
      c%inside_offset = buffers%inside_offset
      if (size(values) > 0) c%values = c_targets(c_loc(values), size(values, kind=c_int64_t))
      status = c_sparse_plan_enqueue(self%handle, queue_of(queue), c, first_of(events), size(events, kind=c_int64_t), &
          place_of(done))
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Prepares the next runs for the present positions of the transform. Blocks.
  subroutine sparse_plan_update(self, transform, options, stat, errmsg)
    class(clsdf_sparse_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call clsdf_finish(c_sparse_plan_update(self%handle, transform%handle, options_for_c(given, options)), stat, errmsg)
  end subroutine

  !> The same with another grid, band and outputs, and with other room.
  subroutine sparse_plan_update_request(self, transform, request, room, options, stat, errmsg)
    class(clsdf_sparse_plan), intent(inout) :: self
    type(clsdf_transform), intent(in) :: transform
    type(clsdf_sparse_request), intent(in) :: request
    type(clsdf_sparse_counts), intent(in) :: room
    class(clsdf_call_options), intent(inout), target, optional :: options
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(caller), target :: given
    call clsdf_finish(c_sparse_plan_update_request(self%handle, transform%handle, sparse_request_for_c(request), room, &
        options_for_c(given, options)), stat, errmsg)
  end subroutine

  function sparse_plan_sign(self, stat, errmsg) result(rule)
    class(clsdf_sparse_plan), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: rule
    call clsdf_finish(c_sparse_plan_sign(self%handle, rule), stat, errmsg)
  end function

  !> Of making or updating it.
  function sparse_plan_statistics(self, stat, errmsg) result(statistics)
    class(clsdf_sparse_plan), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_statistics), target :: statistics
    call clsdf_finish(c_sparse_plan_statistics(self%handle, statistics_for_c(statistics)), stat, errmsg)
  end function

  !> Its grid, band and room.
  subroutine sparse_plan_request(self, grid, band, room, stat, errmsg)
    class(clsdf_sparse_plan), intent(in) :: self
    type(clsdf_grid), intent(out), optional :: grid
    type(clsdf_band), intent(out), optional :: band
    type(clsdf_sparse_counts), intent(out), optional :: room
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(c_sparse_request) :: c
    type(clsdf_sparse_counts) :: counts
    integer(c_int32_t) :: status
    status = c_sparse_plan_request(self%handle, c, counts)
    if (status == CLSDF_OK) then
      if (present(grid)) call take_grid(c%grid, grid)
      if (present(band)) band = c%band
      if (present(room)) room = counts
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The grid and band of request `index`, from 1.
  subroutine plan_request(self, index, grid, band, stat, errmsg)
    class(clsdf_plan), intent(in) :: self
    integer, intent(in) :: index
    type(clsdf_grid), intent(out) :: grid
    type(clsdf_band), intent(out) :: band
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_grid) :: c
    type(clsdf_c_target) :: targets(1)
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    status = c_plan_request(self%handle, int(index - 1, c_int64_t), c, band, targets, 0_c_int64_t, count)
    if (status == CLSDF_OK) call take_grid(c, grid)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! ---- Fields ----

  !> A field with room for these outputs; the values are not set. floor: of CLSDF_SIGN_BELOW, its z.
  subroutine field_create(self, grid, band, sign, mesh_name, outputs, positive_inside, stat, errmsg, floor)
    class(clsdf_field), intent(inout) :: self
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    integer(c_int32_t), intent(in), optional :: sign
    character(*), intent(in), optional :: mesh_name
    integer(c_int32_t), intent(in), optional :: outputs(:)
    logical, intent(in), optional :: positive_inside
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), intent(in), optional :: floor
    character(:), allocatable, target :: text
    type(clsdf_c_description) :: c
    integer(c_int32_t) :: status
    call self%release()
    c%struct_size = c_sizeof(c)
    c%grid = clsdf_grid_for_c(grid)
    c%band = band
    if (present(sign)) c%sign = sign
    if (present(positive_inside)) c%positive_inside = merge(1, 0, positive_inside)
    if (present(floor)) c%floor = floor
    text = c_null_char
    if (present(mesh_name)) text = trim(mesh_name)//c_null_char
    c%mesh_name = c_loc(text)
    status = c_field_create(c, clsdf_outputs_mask(outputs), self%handle)
    if (status == CLSDF_OK) status = c_field_set_index_base(self%handle, 1_c_int32_t)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Gives the field the mesh's groups: a .vti or .vtkhdf gets the group of each sample, from 0, beside its triangle.
  subroutine field_set_groups(self, mesh, stat, errmsg)
    class(clsdf_field), intent(inout) :: self
    type(clsdf_mesh), intent(in) :: mesh
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_field_set_groups(self%handle, mesh%handle), stat, errmsg)
  end subroutine

  !> positive_inside: distances and gradients are negated, also zeros and what lies beyond the band. floor: of
  !> CLSDF_SIGN_BELOW, its z; huge(floor): none, or not known.
  subroutine field_describe(self, grid, band, sign, mesh_name, positive_inside, stat, errmsg, floor)
    class(clsdf_field), intent(in) :: self
    type(clsdf_grid), intent(out), optional :: grid
    type(clsdf_band), intent(out), optional :: band
    integer(c_int32_t), intent(out), optional :: sign
    character(:), allocatable, intent(out), optional :: mesh_name
    logical, intent(out), optional :: positive_inside
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), intent(out), optional :: floor
    type(clsdf_c_description) :: c
    integer(c_int32_t) :: status
    c%struct_size = c_sizeof(c)
    status = c_field_describe(self%handle, c)
    if (status == CLSDF_OK) then
      if (present(grid)) call take_grid(c%grid, grid)
      if (present(band)) band = c%band
      if (present(sign)) sign = c%sign
      if (present(mesh_name)) mesh_name = clsdf_text(c%mesh_name)
      if (present(positive_inside)) positive_inside = c%positive_inside /= 0
      if (present(floor)) floor = c%floor
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The outputs of the field.
  function field_outputs(self, stat, errmsg) result(outputs)
    class(clsdf_field), intent(in) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t), allocatable :: outputs(:)
    integer(c_int32_t) :: mask, i
    mask = 0
    call clsdf_finish(c_field_outputs(self%handle, mask), stat, errmsg)
    outputs = pack([(i, i=0, 31)], [(btest(mask, i), i=0, 31)])
  end function

  !> The memory of an output of a field, and its grid.
  subroutine find_in_field(self, output, type, rank, array, grid, components, status)
    class(clsdf_field), intent(in) :: self
    integer(c_int32_t), intent(in) :: output, type
    integer, intent(in) :: rank
    type(clsdf_c_array), intent(out) :: array
    type(clsdf_grid), intent(out) :: grid
    integer(c_int64_t), intent(out) :: components
    integer(c_int32_t), intent(out) :: status
    type(clsdf_c_description) :: c
    components = 0
    c%struct_size = c_sizeof(c)
    status = c_field_describe(self%handle, c)
    if (status == CLSDF_OK) call take_grid(c%grid, grid)
    if (status == CLSDF_OK) status = c_field_array(self%handle, output, array)
    if (status == CLSDF_OK) call check_memory(output, type, rank, array, components, status)
  end subroutine

  subroutine find_in_slab(self, output, type, rank, array, grid, components, status)
    class(clsdf_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output, type
    integer, intent(in) :: rank
    type(clsdf_c_array), intent(out) :: array
    type(clsdf_grid), intent(out) :: grid
    integer(c_int64_t), intent(out) :: components
    integer(c_int32_t), intent(out) :: status
    type(clsdf_c_target), pointer :: values(:)
    integer :: i
    grid = self%part
    call c_f_pointer(self%values, values, [self%count])
    do i = 1, size(values)
      if (values(i)%output == output) array = values(i)%array
    end do
    call check_memory(output, type, rank, array, components, status)
  end subroutine

  !> A pointer of `rank` to numbers of `type` can be given to the output's memory.
  !> behind: names of further dimensions.
  subroutine check_memory(output, type, rank, array, components, status, behind)
    integer(c_int32_t), intent(in) :: output, type
    integer, intent(in) :: rank
    character(*), intent(in), optional :: behind
    type(clsdf_c_array), intent(in) :: array
    integer(c_int64_t), intent(out) :: components
    integer(c_int32_t), intent(out) :: status
    type(c_output_info) :: info
    integer(c_int32_t) :: own
    character(:), allocatable :: rest
    rest = ''
    if (present(behind)) rest = behind
    info%struct_size = c_sizeof(info) + 1  ! calls fill it
    status = c_output_describe(output, info)
    components = info%components
    if (status /= CLSDF_OK) return
    own = merge(CLSDF_INT32, array%type, array%type == CLSDF_UINT32)
    if (.not. c_associated(array%host)) then
      status = refused('the output '//clsdf_text(info%name)//' is not there; ask for it when the field is computed')
    else if (own /= type .or. (rank == 4 .neqv. components > 1)) then
      status = refused('the output '//clsdf_text(info%name)//' has '//joined([components])//' components of type '// &
          clsdf_type_name(own)//'; give a pointer to such an array, (i, j, k'//rest//'), or (component, i, j, k'//rest// &
          ') if there are several')
    end if
  end subroutine

  ! REPEATED FOR components | r8 | r8 components | i4 i4_3=i4 | i1 i1_3=i1 |
  !     field=slab | field=slab components | field=slab r8 | field=slab r8 components |
  !     field=slab i4 i4_3=i4 | field=slab i1 i1_3=i1

  subroutine field_r4_3(self, output, values, stat, errmsg)
    class(clsdf_field), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_float), pointer, intent(out) :: values(:, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_float), pointer :: memory(:, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_field(self, output, CLSDF_FLOAT32, 3, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, grid%size)
      values(grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  subroutine field_r4_4(self, output, values, stat, errmsg)
    class(clsdf_field), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_float), pointer, intent(out) :: values(:, :, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_float), pointer :: memory(:, :, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_field(self, output, CLSDF_FLOAT32, 4, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, [components, grid%size])
      values(1:, grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine field_r8_3(self, output, values, stat, errmsg)
    class(clsdf_field), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_double), pointer, intent(out) :: values(:, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), pointer :: memory(:, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_field(self, output, CLSDF_FLOAT64, 3, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, grid%size)
      values(grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine field_r8_4(self, output, values, stat, errmsg)
    class(clsdf_field), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_double), pointer, intent(out) :: values(:, :, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), pointer :: memory(:, :, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_field(self, output, CLSDF_FLOAT64, 4, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, [components, grid%size])
      values(1:, grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine field_i4(self, output, values, stat, errmsg)
    class(clsdf_field), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    integer(c_int32_t), pointer, intent(out) :: values(:, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t), pointer :: memory(:, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_field(self, output, CLSDF_INT32, 3, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, grid%size)
      values(grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine field_i1(self, output, values, stat, errmsg)
    class(clsdf_field), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    integer(c_int8_t), pointer, intent(out) :: values(:, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int8_t), pointer :: memory(:, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_field(self, output, CLSDF_UINT8, 3, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, grid%size)
      values(grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine slab_r4_3(self, output, values, stat, errmsg)
    class(clsdf_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_float), pointer, intent(out) :: values(:, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_float), pointer :: memory(:, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_slab(self, output, CLSDF_FLOAT32, 3, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, grid%size)
      values(grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine slab_r4_4(self, output, values, stat, errmsg)
    class(clsdf_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_float), pointer, intent(out) :: values(:, :, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_float), pointer :: memory(:, :, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_slab(self, output, CLSDF_FLOAT32, 4, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, [components, grid%size])
      values(1:, grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine slab_r8_3(self, output, values, stat, errmsg)
    class(clsdf_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_double), pointer, intent(out) :: values(:, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), pointer :: memory(:, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_slab(self, output, CLSDF_FLOAT64, 3, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, grid%size)
      values(grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine slab_r8_4(self, output, values, stat, errmsg)
    class(clsdf_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_double), pointer, intent(out) :: values(:, :, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), pointer :: memory(:, :, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_slab(self, output, CLSDF_FLOAT64, 4, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, [components, grid%size])
      values(1:, grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine slab_i4(self, output, values, stat, errmsg)
    class(clsdf_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    integer(c_int32_t), pointer, intent(out) :: values(:, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t), pointer :: memory(:, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_slab(self, output, CLSDF_INT32, 3, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, grid%size)
      values(grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine slab_i1(self, output, values, stat, errmsg)
    class(clsdf_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    integer(c_int8_t), pointer, intent(out) :: values(:, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int8_t), pointer :: memory(:, :, :)
    type(clsdf_c_array) :: array
    type(clsdf_grid) :: grid
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_slab(self, output, CLSDF_UINT8, 3, array, grid, components, status)
    if (status == CLSDF_OK) then
      call c_f_pointer(array%host, memory, grid%size)
      values(grid%first(1):, grid%first(2):, grid%first(3):) => memory
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! END

  ! ---- Sparse fields ----

  !> floor: of CLSDF_SIGN_BELOW, its z; huge(floor): none, or not known.
  subroutine sparse_field_describe(self, grid, band, sign, mesh_name, stat, errmsg, floor)
    class(clsdf_sparse_field), intent(in) :: self
    type(clsdf_grid), intent(out), optional :: grid
    type(clsdf_band), intent(out), optional :: band
    integer(c_int32_t), intent(out), optional :: sign
    character(:), allocatable, intent(out), optional :: mesh_name
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), intent(out), optional :: floor
    type(clsdf_c_description) :: c
    integer(c_int32_t) :: status
    c%struct_size = c_sizeof(c)
    status = c_sparse_field_describe(self%handle, c)
    if (status == CLSDF_OK) then
      if (present(grid)) call take_grid(c%grid, grid)
      if (present(band)) band = c%band
      if (present(sign)) sign = c%sign
      if (present(mesh_name)) mesh_name = clsdf_text(c%mesh_name)
      if (present(floor)) floor = c%floor
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> All layers, in the field's own memory, as long as it lives.
  subroutine sparse_field_slab(self, slab, stat, errmsg)
    class(clsdf_sparse_field), intent(in) :: self
    type(clsdf_sparse_slab), intent(out) :: slab
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_sparse_slab) :: c
    integer(c_int32_t) :: status
    c%struct_size = c_sizeof(c)
    status = c_sparse_field_slab(self%handle, c)
    if (status == CLSDF_OK) call take_sparse_slab(c, self%index_base, slab)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Triangles count from 0 or from 1: set it before the field is copied, as copies have a number of their own.
  subroutine sparse_field_set_index_base(self, index_base, stat, errmsg)
    class(clsdf_sparse_field), intent(inout) :: self
    integer(c_int32_t), intent(in) :: index_base
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: status
    status = c_sparse_field_set_index_base(self%handle, index_base)
    if (status == CLSDF_OK) self%index_base = index_base
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> bricks(:, n): the first sample of brick n on the lattice, from 1.
  function sparse_bricks(self) result(bricks)
    class(clsdf_sparse_slab), intent(in) :: self
    integer(c_int64_t), allocatable :: bricks(:, :)
    integer(c_int64_t), pointer :: from_0(:, :)
    allocate (bricks(3, self%brick_count))
    if (self%brick_count == 0) return
    call c_f_pointer(self%c%bricks, from_0, [3_c_int64_t, self%brick_count])
    bricks = from_0 + 1
  end function

  !> inside(:, n): the first sample of a run of bricks along x that are inside and have no values, from 1, and the number of
  !> the bricks.
  function sparse_inside(self) result(inside)
    class(clsdf_sparse_slab), intent(in) :: self
    integer(c_int64_t), allocatable :: inside(:, :)
    integer(c_int64_t), pointer :: from_0(:, :)
    allocate (inside(4, self%run_count))
    if (self%run_count == 0) return
    call c_f_pointer(self%c%inside, from_0, [4_c_int64_t, self%run_count])
    inside = from_0
    inside(:3, :) = inside(:3, :) + 1
  end function

  !> The number of the brick that has the sample's values; 0: none. The sample counts on the lattice from 1.
  subroutine sparse_find(self, sample, number, stat, errmsg)
    class(clsdf_sparse_slab), intent(in) :: self
    integer(c_int64_t), intent(in) :: sample(3)
    integer(c_int64_t), intent(out) :: number
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_sparse_find(self%c, sample - 1, number), stat, errmsg)
    number = number + 1
  end subroutine

  !> The distances of samples of the layers, near the surface or not. band: the field's. Samples count on the lattice
  !> from 1.
  subroutine sparse_distances(self, band, samples, distances, stat, errmsg)
    class(clsdf_sparse_slab), intent(in) :: self
    type(clsdf_band), intent(in) :: band
    integer(c_int64_t), intent(in) :: samples(:, :)  !< (3, n)
    real(c_float), intent(inout), contiguous :: distances(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int64_t), allocatable :: from_0(:, :)
    integer(c_int32_t) :: status
    status = CLSDF_OK
    if (size(samples, 1) /= 3 .or. size(samples, 2) /= size(distances)) status = refused('the array of the samples has the '// &
        'shape '//joined(shape(samples, c_int64_t))//' and that of the distances '// &
        joined(shape(distances, c_int64_t))//'; give them (3, n) and (n)')
    if (status == CLSDF_OK) then
      allocate (from_0(3, size(samples, 2)))
      from_0 = samples - 1
      status = c_sparse_distances(self%c, band, from_0, size(distances, kind=c_int64_t), distances)
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine find_in_sparse(self, output, type, rank, array, components, status)
    class(clsdf_sparse_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output, type
    integer, intent(in) :: rank
    type(clsdf_c_array), intent(out) :: array
    integer(c_int64_t), intent(out) :: components
    integer(c_int32_t), intent(out) :: status
    type(clsdf_c_target), pointer :: values(:)
    integer :: i
    call c_f_pointer(self%c%values%items, values, [self%c%values%count])
    do i = 1, int(self%c%values%count)
      if (values(i)%output == output) array = values(i)%array
    end do
    call check_memory(output, type, rank, array, components, status, ', brick')
  end subroutine

  ! REPEATED FOR i4 | i1

  subroutine sparse_r4_4(self, output, values, stat, errmsg)
    class(clsdf_sparse_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_float), pointer, intent(out) :: values(:, :, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_array) :: array
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_sparse(self, output, CLSDF_FLOAT32, 3, array, components, status)
    if (status == CLSDF_OK) call c_f_pointer(array%host, values, [8_c_int64_t, 8_c_int64_t, 8_c_int64_t, self%brick_count])
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  subroutine sparse_i4_4(self, output, values, stat, errmsg)
    class(clsdf_sparse_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    integer(c_int32_t), pointer, intent(out) :: values(:, :, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_array) :: array
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_sparse(self, output, CLSDF_INT32, 3, array, components, status)
    if (status == CLSDF_OK) call c_f_pointer(array%host, values, [8_c_int64_t, 8_c_int64_t, 8_c_int64_t, self%brick_count])
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine sparse_i1_4(self, output, values, stat, errmsg)
    class(clsdf_sparse_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    integer(c_int8_t), pointer, intent(out) :: values(:, :, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_array) :: array
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_sparse(self, output, CLSDF_UINT8, 3, array, components, status)
    if (status == CLSDF_OK) call c_f_pointer(array%host, values, [8_c_int64_t, 8_c_int64_t, 8_c_int64_t, self%brick_count])
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! END

  ! REPEATED FOR r8

  subroutine sparse_r4_5(self, output, values, stat, errmsg)
    class(clsdf_sparse_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_float), pointer, intent(out) :: values(:, :, :, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_array) :: array
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_sparse(self, output, CLSDF_FLOAT32, 4, array, components, status)
    if (status == CLSDF_OK) call c_f_pointer(array%host, values, &
        [components, 8_c_int64_t, 8_c_int64_t, 8_c_int64_t, self%brick_count])
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! REPEATED BY repeat.py

  subroutine sparse_r8_5(self, output, values, stat, errmsg)
    class(clsdf_sparse_slab), intent(in) :: self
    integer(c_int32_t), intent(in) :: output
    real(c_double), pointer, intent(out) :: values(:, :, :, :, :)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_array) :: array
    integer(c_int64_t) :: components
    integer(c_int32_t) :: status
    values => null()
    call find_in_sparse(self, output, CLSDF_FLOAT64, 4, array, components, status)
    if (status == CLSDF_OK) call c_f_pointer(array%host, values, &
        [components, 8_c_int64_t, 8_c_int64_t, 8_c_int64_t, self%brick_count])
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  ! END

  ! ---- Points in files ----

  !> Reads points from .npy (n, 3), .csv (columns x, y, z) or .ply.
  subroutine clsdf_points_read(path, points, stat, errmsg)
    character(*), intent(in) :: path
    real(c_double), allocatable, intent(out) :: points(:, :)  !< (3, n)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), pointer :: data(:, :)
    type(c_ptr) :: handle, first
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    status = c_points_read(trim(path)//c_null_char, handle)
    if (status == CLSDF_OK) status = c_points_data(handle, first, count)
    if (status == CLSDF_OK) then
      allocate (points(3, count))
      if (count > 0) then
        call c_f_pointer(first, data, [3_c_int64_t, count])
        points = data
      end if
    end if
    call c_points_release(handle)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Writes what a query found, a row for each point: .npy, .csv or .ply. Packed arrays of the types that
  !> clsdf_output_describe() states. Triangles are written as they are.
  subroutine clsdf_points_write(points, results, path, stat, errmsg)
    real(c_double), intent(in), contiguous :: points(:, :)  !< (3, n)
    type(clsdf_target), intent(in) :: results(:)
    character(*), intent(in) :: path
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_target) :: c(size(results))
    integer(c_int64_t) :: count
    integer(c_int32_t) :: status
    integer :: i
    status = CLSDF_OK
    count = size(points, 2, c_int64_t)
    if (size(points, 1) /= 3) status = refused('the array of the points has the shape '// &
        joined(shape(points, c_int64_t))//'; give it (3, n)')
    call clsdf_targets_of_samples(results, [count], 1, c, status)
    do i = 1, size(c)
      if (status /= CLSDF_OK) exit
      call clsdf_pack_for_c(results(i)%array, count, c(i), status)
    end do
    if (status == CLSDF_OK) status = c_points_write(points, count, c, size(c, kind=c_int64_t), trim(path)//c_null_char, &
        clsdf_outputs_mask(results%output))
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> A packed array of `items` items as C describes it, without strides. Triangles are uint32 in files.
  subroutine clsdf_pack_for_c(array, items, c, status)
    type(clsdf_array), intent(in) :: array
    integer(c_int64_t), intent(in) :: items
    type(clsdf_c_target), intent(inout) :: c
    integer(c_int32_t), intent(inout) :: status
    integer(c_int64_t) :: packed
    logical :: is_packed
    integer :: i
    packed = bytes_of(array%type)
    is_packed = c%array%component_stride == 0 .or. c%array%component_stride == packed
    do i = 1, array%rank
      is_packed = is_packed .and. array%strides(i) == packed
      packed = packed*array%shape(i)
    end do
    if (items > 0 .and. .not. is_packed) then
      status = refused('the array of the output '//clsdf_text(output_name(c%output))//' is not packed, with components '// &
          'first; write a copy of it')
      return
    end if
    c%array%strides = 0
    c%array%component_stride = 0
    c%array%count = items
    if (c%array%type == CLSDF_INT32) c%array%type = CLSDF_UINT32
  end subroutine

  function output_name(output) result(name)
    integer(c_int32_t), intent(in) :: output
    type(c_ptr) :: name
    type(c_output_info) :: info
    info%struct_size = c_sizeof(info) + 1  ! calls fill it
    name = c_null_ptr
    if (c_output_describe(output, info) == CLSDF_OK) name = info%name
  end function

  !> The error that clsdf_points_write() would give for the ending or the folder.
  subroutine clsdf_points_check_path(path, stat, errmsg)
    character(*), intent(in) :: path
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_points_check_path(trim(path)//c_null_char), stat, errmsg)
  end subroutine

  !> For a program that is about to end: removes the unfinished files of all threads. With clsdf_io, call
  !> clsdf_io_abandon_unfinished_files() instead.
  subroutine clsdf_abandon_unfinished_files()
    call c_abandon_unfinished_files()
  end subroutine

  ! ---- References ----

  elemental function sparse_field_is_set(self) result(is_set)
    class(clsdf_sparse_field), intent(in) :: self
    logical :: is_set
    is_set = c_associated(self%handle)
  end function

  subroutine sparse_field_release(self)
    class(clsdf_sparse_field), intent(inout) :: self
    call c_sparse_field_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine sparse_field_assign(left, right)
    class(clsdf_sparse_field), intent(inout) :: left
    type(clsdf_sparse_field), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_sparse_field_retain(right%handle)
    left%handle = right%handle
    left%index_base = right%index_base
    call c_sparse_field_release(before)
  end subroutine

  impure elemental subroutine sparse_field_end(self)
    type(clsdf_sparse_field), intent(inout) :: self
    call self%release()
  end subroutine

  ! REPEATED FOR device=mesh | device=transform | device=scene | device=plan | device=point_plan | device=link_plan |
  !     device=sparse_plan | device=field

  elemental function device_is_set(self) result(is_set)
    class(clsdf_device), intent(in) :: self
    logical :: is_set
    is_set = c_associated(self%handle)
  end function

  ! REPEATED BY repeat.py

  elemental function mesh_is_set(self) result(is_set)
    class(clsdf_mesh), intent(in) :: self
    logical :: is_set
    is_set = c_associated(self%handle)
  end function

  elemental function transform_is_set(self) result(is_set)
    class(clsdf_transform), intent(in) :: self
    logical :: is_set
    is_set = c_associated(self%handle)
  end function

  elemental function scene_is_set(self) result(is_set)
    class(clsdf_scene), intent(in) :: self
    logical :: is_set
    is_set = c_associated(self%handle)
  end function

  elemental function plan_is_set(self) result(is_set)
    class(clsdf_plan), intent(in) :: self
    logical :: is_set
    is_set = c_associated(self%handle)
  end function

  elemental function point_plan_is_set(self) result(is_set)
    class(clsdf_point_plan), intent(in) :: self
    logical :: is_set
    is_set = c_associated(self%handle)
  end function

  elemental function link_plan_is_set(self) result(is_set)
    class(clsdf_link_plan), intent(in) :: self
    logical :: is_set
    is_set = c_associated(self%handle)
  end function

  elemental function sparse_plan_is_set(self) result(is_set)
    class(clsdf_sparse_plan), intent(in) :: self
    logical :: is_set
    is_set = c_associated(self%handle)
  end function

  elemental function field_is_set(self) result(is_set)
    class(clsdf_field), intent(in) :: self
    logical :: is_set
    is_set = c_associated(self%handle)
  end function

  ! END

  ! REPEATED FOR device=mesh | device=transform | device=scene | device=plan | device=point_plan | device=link_plan |
  !     device=sparse_plan | device=field | device=thread_limit

  subroutine device_release(self)
    class(clsdf_device), intent(inout) :: self
    call c_device_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine device_assign(left, right)
    class(clsdf_device), intent(inout) :: left
    type(clsdf_device), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_device_retain(right%handle)
    left%handle = right%handle
    call c_device_release(before)
  end subroutine

  impure elemental subroutine device_end(self)
    type(clsdf_device), intent(inout) :: self
    call self%release()
  end subroutine

  ! REPEATED BY repeat.py

  subroutine mesh_release(self)
    class(clsdf_mesh), intent(inout) :: self
    call c_mesh_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine mesh_assign(left, right)
    class(clsdf_mesh), intent(inout) :: left
    type(clsdf_mesh), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_mesh_retain(right%handle)
    left%handle = right%handle
    call c_mesh_release(before)
  end subroutine

  impure elemental subroutine mesh_end(self)
    type(clsdf_mesh), intent(inout) :: self
    call self%release()
  end subroutine

  subroutine transform_release(self)
    class(clsdf_transform), intent(inout) :: self
    call c_transform_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine transform_assign(left, right)
    class(clsdf_transform), intent(inout) :: left
    type(clsdf_transform), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_transform_retain(right%handle)
    left%handle = right%handle
    call c_transform_release(before)
  end subroutine

  impure elemental subroutine transform_end(self)
    type(clsdf_transform), intent(inout) :: self
    call self%release()
  end subroutine

  subroutine scene_release(self)
    class(clsdf_scene), intent(inout) :: self
    call c_scene_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine scene_assign(left, right)
    class(clsdf_scene), intent(inout) :: left
    type(clsdf_scene), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_scene_retain(right%handle)
    left%handle = right%handle
    call c_scene_release(before)
  end subroutine

  impure elemental subroutine scene_end(self)
    type(clsdf_scene), intent(inout) :: self
    call self%release()
  end subroutine

  subroutine plan_release(self)
    class(clsdf_plan), intent(inout) :: self
    call c_plan_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine plan_assign(left, right)
    class(clsdf_plan), intent(inout) :: left
    type(clsdf_plan), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_plan_retain(right%handle)
    left%handle = right%handle
    call c_plan_release(before)
  end subroutine

  impure elemental subroutine plan_end(self)
    type(clsdf_plan), intent(inout) :: self
    call self%release()
  end subroutine

  subroutine point_plan_release(self)
    class(clsdf_point_plan), intent(inout) :: self
    call c_point_plan_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine point_plan_assign(left, right)
    class(clsdf_point_plan), intent(inout) :: left
    type(clsdf_point_plan), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_point_plan_retain(right%handle)
    left%handle = right%handle
    call c_point_plan_release(before)
  end subroutine

  impure elemental subroutine point_plan_end(self)
    type(clsdf_point_plan), intent(inout) :: self
    call self%release()
  end subroutine

  subroutine link_plan_release(self)
    class(clsdf_link_plan), intent(inout) :: self
    call c_link_plan_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine link_plan_assign(left, right)
    class(clsdf_link_plan), intent(inout) :: left
    type(clsdf_link_plan), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_link_plan_retain(right%handle)
    left%handle = right%handle
    call c_link_plan_release(before)
  end subroutine

  impure elemental subroutine link_plan_end(self)
    type(clsdf_link_plan), intent(inout) :: self
    call self%release()
  end subroutine

  subroutine sparse_plan_release(self)
    class(clsdf_sparse_plan), intent(inout) :: self
    call c_sparse_plan_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine sparse_plan_assign(left, right)
    class(clsdf_sparse_plan), intent(inout) :: left
    type(clsdf_sparse_plan), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_sparse_plan_retain(right%handle)
    left%handle = right%handle
    call c_sparse_plan_release(before)
  end subroutine

  impure elemental subroutine sparse_plan_end(self)
    type(clsdf_sparse_plan), intent(inout) :: self
    call self%release()
  end subroutine

  subroutine field_release(self)
    class(clsdf_field), intent(inout) :: self
    call c_field_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine field_assign(left, right)
    class(clsdf_field), intent(inout) :: left
    type(clsdf_field), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_field_retain(right%handle)
    left%handle = right%handle
    call c_field_release(before)
  end subroutine

  impure elemental subroutine field_end(self)
    type(clsdf_field), intent(inout) :: self
    call self%release()
  end subroutine

  subroutine thread_limit_release(self)
    class(clsdf_thread_limit), intent(inout) :: self
    call c_thread_limit_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine thread_limit_assign(left, right)
    class(clsdf_thread_limit), intent(inout) :: left
    type(clsdf_thread_limit), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_thread_limit_retain(right%handle)
    left%handle = right%handle
    call c_thread_limit_release(before)
  end subroutine

  impure elemental subroutine thread_limit_end(self)
    type(clsdf_thread_limit), intent(inout) :: self
    call self%release()
  end subroutine

  ! END

end module
