! Every call: its result, and its error.
module collectors
  use, intrinsic :: iso_c_binding
  use clsdf
  use test
  implicit none
  type, extends(clsdf_slab_sink) :: collector
    real(4), allocatable :: phi(:, :, :)
    integer, allocatable :: triangle(:, :, :)
    integer :: slabs = 0
    logical :: refuses = .false.
  contains
    procedure :: take
  end type
contains

  ! Names that the module keeps to itself.
  subroutine on_progress() bind(C, name='on_progress')
  end subroutine
  subroutine on_stop() bind(C, name='on_stop')
  end subroutine
  subroutine on_log() bind(C, name='on_log')
  end subroutine
  subroutine on_slab() bind(C, name='on_slab')
  end subroutine

  subroutine take(sink, slab, status)
    class(collector), intent(inout) :: sink
    type(clsdf_slab), intent(in) :: slab
    integer(c_int32_t), intent(inout) :: status
    real(4), pointer :: phi(:, :, :), gradient(:, :, :, :)
    real(8), pointer :: doubles(:, :, :)
    integer, pointer :: triangle(:, :, :)
    integer :: k, stat
    character(200) :: errmsg
    if (sink%refuses) status = CLSDF_CANCELLED
    call slab%array(CLSDF_DISTANCE, phi)
    call slab%array(CLSDF_TRIANGLE, triangle)
    call check(all(lbound(phi) == slab%part%first) .and. all(ubound(triangle) == slab%part%last()), 'bounds of a slab')
    do k = lbound(phi, 3), ubound(phi, 3)
      sink%phi(:, :, k) = phi(:, :, k)
      sink%triangle(:, :, k) = triangle(:, :, k)
    end do
    sink%slabs = sink%slabs + 1
    call slab%array(CLSDF_DISTANCE, doubles, stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'float')
    call slab%array(CLSDF_GRADIENT, gradient, stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'gradient is not there')
  end subroutine

end module

program calls
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use clsdf
  use collectors
  use test
  implicit none
  type, extends(clsdf_call_options) :: watcher
    integer :: calls = 0, stop_after = huge(1), messages = 0
    character(200) :: message = ''
  end type
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: grid
  type(clsdf_band) :: band
  real(4), allocatable :: expected(:, :, :)
  integer, allocatable :: numbers(:, :, :)
  integer :: stat
  character(400) :: errmsg

  call numbers_and_texts()
  call devices()
  call meshes()
  call mesh%shape('knot')
  call transform%create(device, mesh)
  band = clsdf_band_symmetric(0.3d0)
  call grid%around(mesh, 40, band)
  allocate (expected(grid%size(1), grid%size(2), grid%size(3)), numbers(grid%size(1), grid%size(2), grid%size(3)))
  call transform%compute(grid, band, expected, triangle=numbers)
  call grids()
  call options()
  call slabs_and_fields()
  call other_calls()
  call terrain()
  call detail()
  call errors()

contains

  ! A lamp on a box, above a gap and open towards it.
  subroutine detail()
    integer(4), parameter :: faces(3, 12) = reshape([1, 5, 7, 1, 7, 3, 2, 4, 8, 2, 8, 6, 1, 2, 6, 1, 6, 5, 3, 7, 8, &
        3, 8, 4, 5, 6, 8, 5, 8, 7, 1, 3, 4, 1, 4, 2], [3, 12])
    real(8) :: corners(3, 16)
    integer :: i
    type(clsdf_mesh) :: lamp
    type(clsdf_topology) :: topology
    type(clsdf_transform) :: union
    real(8) :: distance(1)
    integer(4) :: triangle(1)
    integer(1) :: site(1)
    do i = 1, 8
      corners(:, i) = [ibits(i - 1, 0, 1), ibits(i - 1, 1, 1), ibits(i - 1, 2, 1)]
    end do
    corners(:, 9:) = spread([1d0, 1d0, 4.1d0], 2, 8) + corners(:, :8) * spread([1d0, 1d0, 2d0], 2, 8)
    corners(:, :8) = corners(:, :8) * spread([8d0, 8d0, 4d0], 2, 8)
    call lamp%create(corners, reshape([faces, faces(:, :10) + 8], [3, 22]))
    topology = lamp%topology()
    call check(topology%detail_parts == 1 .and. topology%detail_faces == 10 .and. topology%first_detail_face == 12, &
        'a detail')
    ! Two boxes that overlap: a bar.
    corners(:, :8) = corners(:, :8) / spread([4d0, 4d0, 2d0], 2, 8)
    corners(:, 9:) = corners(:, :8) + spread([1d0, 0d0, 0d0], 2, 8)
    call lamp%create(corners, reshape([faces, faces + 8], [3, 24]))
    call union%create(device, lamp, surface=CLSDF_SURFACE_OUTER)
    topology = union%topology()
    call check(topology%hidden_faces > 0 .and. topology%parts == 2, 'faces within the other box')
    call union%query(reshape([1.75d0, 1d0, 0.25d0], [3, 1]), 9d0, distance, triangle=triangle, site=site)
    call check(abs(distance(1) + 0.25d0) < 1d-12 .and. triangle(1) >= 1 .and. triangle(1) <= 24 .and. site(1) == 6, &
        'the distance to the union')
    call union%create(device, lamp, surface=2, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'surface')
    call lamp%release()
  end subroutine

  ! Two triangles at z = 2, with a floor.
  subroutine terrain()
    real(8), parameter :: corners(3, 4) = reshape([0d0, 0d0, 2d0, 4d0, 0d0, 2d0, 4d0, 4d0, 2d0, 0d0, 4d0, 2d0], [3, 4])
    integer(4), parameter :: faces(3, 2) = reshape([1, 2, 3, 1, 3, 4], [3, 2])
    real(8) :: points(3, 2) = reshape([2d0, 2d0, 1d0, 2d0, 2d0, 3d0], [3, 2])
    real(8) :: distance(2)
    type(clsdf_mesh) :: own, closed, cut
    type(clsdf_outer_report) :: report
    integer(4), allocatable :: given(:)
    type(clsdf_topology) :: topology
    type(clsdf_transform) :: below
    call own%create(corners, faces, 'terrain')
    topology = own%topology()
    call check(topology%rim_loops == 1 .and. topology%downward_faces == 0, 'a terrain')
    call own%close_down(-1d0, closed)
    topology = closed%topology()
    call check(topology%balanced, 'a terrain with walls and a floor')
    call closed%outer(cut, report=report)
    call check(report%volume == 48d0 .and. report%hidden_faces == 0, 'its outer surface')
    call cut%given_faces(given)
    topology = cut%topology()
    call check(size(given) > 0 .and. minval(given) >= 1 .and. topology%balanced, 'the faces as given')
    call own%outer(cut, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'outer surface')
    call own%close_down(2d0, closed, stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'lowest vertex')
    call below%create(device, own, CLSDF_SIGN_BELOW, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'needs a floor')
    call below%create(device, own, CLSDF_SIGN_BELOW, floor=-1d0)
    call check(below%sign() == CLSDF_SIGN_BELOW, 'its sign')
    call below%query(points, 100d0, distance)
    call check(all(abs(distance - [-1d0, 1d0]) < 1d-12), 'distances below and above it')
  end subroutine

  subroutine numbers_and_texts()
    type(clsdf_output_info) :: info
    type(clsdf_length) :: length
    call check(clsdf_version() == CLSDF_MODULE_VERSION, 'the version of the module')
    call check(clsdf_version_text() == '0.1.0', 'its text')
    call check(clsdf_status_name(CLSDF_INVALID_MESH) == 'invalid_mesh', 'the name of a status')
    call check(clsdf_type_name(CLSDF_FLOAT64) == 'double', 'the name of a type')
    call check(clsdf_sign_name(CLSDF_SIGN_PARITY) == 'parity', 'the name of a sign rule')
    call check(clsdf_device_kind_name(CLSDF_GPU) == 'gpu', 'the name of a kind')
    call check(clsdf_device_source_name(CLSDF_UNREGISTERED) == 'unregistered', 'the name of a source')
    call check(clsdf_output_count() == CLSDF_BODY + 1, 'outputs')
    call clsdf_output_describe(CLSDF_GRADIENT, info)
    call check(info%name == 'gradient' .and. info%components == 3 .and. len(info%description) > 10, 'the table of outputs')
    length = clsdf_length(2, CLSDF_VOXELS)
    call check(abs(clsdf_length_resolve(length, 0.25d0, 10d0) - 0.5d0) < 1d-15, 'a length in voxels')
    call clsdf_output_describe(77, info, stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, '77')
  end subroutine

  subroutine devices()
    type(clsdf_device_info), allocatable :: list(:)
    type(clsdf_device_info) :: info
    type(clsdf_device) :: other, part
    type(clsdf_thread_limit) :: limit
    character(:), allocatable :: folder
    type(c_ptr) :: context, id, queue, memory
    character(8) :: number
    call clsdf_devices_list(list)
    call check(size(list) > 0 .and. list(1)%index == 0, 'devices')
    call device%automatic()
    call device%describe(info)
    call check(len(info%name) > 0 .and. info%fp64 .and. info%why_not == '' .and. info%only_if_named == '' .and. info%memory > 0, &
        'a device')
    call check((info%source == CLSDF_REGISTERED) .eqv. (info%driver_file == ''), 'how it was found')
    call check(list(info%index + 1)%name == info%name, 'is in the list')
    write (number, '(i0)') info%index
    call other%select(trim(number))
    call other%strongest()
    call other%of_rank(0, 1)
    call device%handles(context, id, queue)
    call other%from_handles(context, id, queue)
    call other%describe(info)
    call check(info%index >= 0, 'a device of handles')
    call device%limited(part, memory=100000000_8)
    call check(part%is_set(), 'a device with limits')
    call other%select('no such device', stat, errmsg)
    call fails(stat, CLSDF_NO_DEVICE, errmsg, 'no such device')
    call check(.not. other%is_set(), 'a handle after an error is not set')
    call device%import_memory(-1, 4096_c_int64_t, memory, stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'descriptor -1 is not open')
    call check(.not. c_associated(memory), 'no memory after an error')
    call device%record_folder(folder)
    call device%keep_records('')
    call device%record_folder(folder)
    call check(folder == '', 'no records')
    call device%read_programs('')
    call device%write_programs('')
    call clsdf_default_record_folder(folder)
    call check(len(folder) > 0, 'the folder of the command')
    call limit%set(1)
    call check(clsdf_thread_count() == 1, 'a limit of threads')
    call limit%release()
    call device%automatic()
  end subroutine

  subroutine meshes()
    type(clsdf_mesh) :: own, welded
    type(clsdf_topology) :: topology
    type(clsdf_defects) :: defects
    type(clsdf_box) :: box
    integer(c_int32_t) :: rule
    integer(c_int8_t) :: colours(3, 3)
    character(:), allocatable :: warning
    real(8) :: x(3, 4)
    real(8), pointer :: vertices(:, :), again(:, :)
    integer :: triangles(3, 4)
    call tetrahedron(x, triangles)
    call own%create(x, triangles(:, :3), 'open')
    call own%vertices(vertices)
    call own%set_positions(2*x)
    call own%vertices(again)
    call check(associated(vertices, again), 'new positions lie where the old ones did')
    call own%create(vertices, triangles(:, :3), 'open')
    call own%vertices(vertices)
    call check(all(vertices == 2*x), 'a mesh of its own vertices')
    call own%set_positions(x)
    topology = own%topology()
    call check(.not. topology%closed .and. topology%open_edges == 3 .and. size(topology%first_open) == 3, 'open edges')
    call check(topology%boundary_edges == 3 .and. topology%parts == 0 .and. topology%joined_vertices == 0, 'counts')
    call check(maxval(abs(topology%first_open(1)%from - topology%first_open(1)%to)) == 1, 'an open edge')
    defects = own%defects()
    call check(defects%components == 1 .and. defects%duplicate_faces == 0, 'defects')
    call own%sign(rule, warning=warning)
    call check(rule == CLSDF_SIGN_NONE .and. index(warning, 'not closed') > 0, 'a warning')
    call own%sign(rule, CLSDF_SIGN_PARITY, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_MESH, errmsg, 'parity')
    box = own%box()
    call check(all(box%upper == 1) .and. all(box%lower == 0), 'a box')
    call own%set_positions(2*x)
    call own%vertices(vertices)
    call check(all(vertices == 2*x), 'new positions')
    call own%set_positions(real(x, 4))
    block
      integer(8) :: hash
      hash = own%hash()
      call own%set_positions(3*x)
      call check(own%hash() /= hash, 'the hash of other positions')
      call own%set_positions(real(x, 4))
      call check(own%hash() == hash, 'the hash of the same positions')
    end block
    call own%weld(welded)
    call check(welded%index_base() == 1, 'a welded mesh')
    call own%weld(welded, 4d0, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'no face')
    block
      type(clsdf_weld_report) :: report
      character(:), allocatable :: warning
      call own%weld(welded, 1d-3, report=report, warning=warning)
      call welded%vertices(vertices)
      call check(size(vertices, 2) == size(x, 2), 'a mesh welded within a length')
      call check(report%lost_faces == 0 .and. report%volume_before == report%volume_after .and. warning == '', 'unchanged')
      call own%weld(welded, 4d0, stat, errmsg, report, warning)
      call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'no face')
      call own%set_positions(x*spread([1d0, 1d0, 1d-4], 2, size(x, 2)))
      call own%weld(welded, 1d-3, report=report, warning=warning)
      call check(report%lost_faces == 2 .and. report%coinciding_faces == 0, 'two of the three faces are flat')
      call check(index(warning, 'give a smaller') > 0, 'the remedy')
      call own%set_positions(x)
    end block
    call own%set_index_base(0)
    call own%weld(welded)
    call check(welded%index_base() == 0, 'a welded mesh has the index base of the mesh')
    colours = 100
    call own%write('fortran_mesh.ply', colours)
    call welded%read('fortran_mesh.ply')
    call welded%vertices(vertices)
    call check(all(vertices == x), 'a mesh from a file')
    call welded%read([character(20) :: 'fortran_mesh.ply', 'fortran_mesh.ply'])
    call welded%vertices(vertices)
    call check(size(vertices, 2) == 2 * size(x, 2), 'a mesh from two files')
    call welded%read('fortran_mesh.ply', scale=0.5d0, translate=[1d0, 2d0, 3d0])
    call welded%vertices(vertices)
    call check(all(vertices == 0.5d0*x + spread([1d0, 2d0, 3d0], 2, size(x, 2))), 'in another unit, at another place')
    call welded%read('fortran_mesh.ply', scale=0d0, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'scale: 0')
    block
      integer :: unit
      open (newunit=unit, file='fortran_bad.obj', status='replace')
      write (unit, '(a)') 'v 0 0 0', 'v 1.0D+00 0 0', 'v 0 1 0', 'f 1 2 3', 'f 1 2 9'
      close (unit)
      call welded%read('fortran_bad.obj', stat=stat, errmsg=errmsg)
      call fails(stat, CLSDF_INVALID_MESH, errmsg, 'skip_bad_facets')
      call welded%read('fortran_bad.obj', skip_bad_facets=.true.)
      call welded%vertices(vertices)
      call check(size(vertices, 2) == 3 .and. vertices(1, 2) == 1, 'a face is left out')
    end block
    call welded%read('fortran_mesh.ply', up='y')
    call welded%vertices(vertices)
    call check(all(vertices(1, :) == x(1, :) .and. vertices(2, :) == -x(3, :) .and. vertices(3, :) == x(2, :)), &
      'with y up')
    call welded%read('fortran_mesh.ply', rotate=[0d0, 0d0, -90d0])
    call welded%vertices(vertices)
    call check(all(vertices(1, :) == x(2, :) .and. vertices(2, :) == -x(1, :) .and. vertices(3, :) == x(3, :)), &
      'turned about z')
    call welded%read('fortran_mesh.ply', up='w', stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, "up: 'w'")
    call groups(own)
    call welded%read('fortran_mesh.ply')
    call own%write('fortran_mesh.ply', colours(:2, :), stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'colours')
    triangles(2, 3) = 5
    call own%create(x, triangles, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_MESH, errmsg, '5')
    call own%create(x(:2, :), triangles, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'vertices has the shape (2, 4); give it (3, n) or (n, 3)')
    call check(clsdf_shape_count() > 3 .and. clsdf_shape_name(1) /= '' .and. clsdf_shape_description(1) /= '', 'shapes')
    call check(clsdf_shape_name(int(clsdf_shape_count()) + 1) == '', 'and no more')
  end subroutine

  !> Of an open tetrahedron, three triangles, which is in the file, with the colour 100.
  subroutine groups(own)
    type(clsdf_mesh), intent(inout) :: own
    type(clsdf_mesh) :: other
    integer, allocatable :: numbers(:)
    integer :: stat
    character(200) :: errmsg
    call other%read('fortran_mesh.ply', group_by='red')
    call other%group_numbers(numbers)
    call check(other%group_count() == 1 .and. other%group_name(1) == '100', 'groups by a property')
    call check(size(numbers) == 3 .and. all(numbers == 1), 'of their triangles')
    call other%read([character(20) :: 'fortran_mesh.ply', 'fortran_mesh.ply'])
    call other%group_numbers(numbers)
    call check(other%group_name(1) == 'fortran_mesh' .and. other%group_name(2) == 'fortran_mesh_2', 'two files')
    call check(all(numbers(:3) == 1) .and. all(numbers(4:) == 2) .and. size(numbers) == 6, 'and their triangles')
    call own%set_groups([character(6) :: 'wall', 'inlet'], [1, 2, 1])
    call own%weld(other)
    call other%group_numbers(numbers)
    call check(other%group_name(1) == 'wall' .and. other%group_name(2) == 'inlet', 'groups of a mesh')
    call check(all(numbers == [1, 2, 1]), 'and of its triangles')
    call check(other%group_name(3, stat, errmsg) == '', 'no name')
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, '2 groups')
    call own%set_groups(['wall'], [1, 2, 1], stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'names')
    call own%set_groups(['wall'], numbers(:0), stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, '3 triangles')
    call own%set_groups([character(1) ::], numbers(:0))
    call own%group_numbers(numbers)
    call check(own%group_count() == 0 .and. size(numbers) == 0, 'a mesh without groups')
  end subroutine

  subroutine grids()
    type(clsdf_grid) :: part
    type(clsdf_grid), allocatable :: parts(:)
    type(clsdf_box) :: box
    call check(all(grid%first == 1) .and. grid%sample_count() == size(expected), 'a grid')
    call grid%validate()
    part = grid%part([3, 1, 2], [4, 5, 6])
    call check(all(part%first == [3, 1, 2]) .and. all(part%last() == [6, 5, 7]), 'a part')
    part = part%part(part%first + 1, [1_8, 1_8, 1_8])
    call check(all(part%first == [4, 2, 3]), 'a part of a part')
    part = part%grown(3)
    call check(all(part%first == [1, -1, 0]) .and. all(part%size == 7), 'a grown part')
    part = grid%block([-4, 0, 9], [2, 2, 2])
    call check(all(abs(part%position(-4, 0, 9) - grid%position(-4, 0, 9)) < 1d-12), 'a block has the lattice''s positions')
    box = part%box()
    call check(all(abs(box%lower - (grid%origin + ([-4, 0, 9] - 1)*grid%spacing)) < 1d-12), 'a box of a block')
    part = grid%refined(2)
    call check(part%size(1) == 2*grid%size(1) - 1 .and. abs(part%voxel() - grid%voxel()/2) < 1d-12, 'a refined grid')
    part = grid%refined_cells(2)
    call check(part%size(1) == 2*grid%size(1), 'refined cells')
    part = grid%cell_centred()
    call check(all(abs(part%position(1, 1, 1) - grid%position(1, 1, 1) - grid%spacing/2) < 1d-12), 'centres of cells')
    call clsdf_slabs_of(grid, parts)
    call check(size(parts) >= 1 .and. all(parts(1)%first == 1), 'slabs')
    call part%between(clsdf_box([0d0, 0d0, 0d0], [1d0, 2d0, 4d0]), samples=[3, 3, 3])
    call check(all(part%spacing == [0.5d0, 1d0, 2d0]) .and. all(part%size == 3) .and. all(part%origin == 0), 'a box')
    call part%between(clsdf_box([0d0, 0d0, 0d0], [1d0, 2d0, 4d0]), cells=[2, 2, 2], cell_centred=.true.)
    call check(all(part%size == 2) .and. all(part%origin == [0.25d0, 0.5d0, 1d0]), 'its cells')
    call part%between(clsdf_box([0d0, 0d0, 4d0], [1d0, 2d0, 4d0]), samples=[3, 3, 1])
    call check(all(part%size == [3, 3, 1]) .and. part%origin(3) == 4 .and. part%spacing(3) == 0.5d0, 'a slice')
    call part%around(mesh%box(), spacing=[0.1d0, 0.1d0, 0.1d0], margin=clsdf_length(0.3d0), cubic=.true., cell_centred=.true.)
    call check(all(part%size == part%size(1)) .and. abs(part%voxel() - 0.1d0) < 1d-12, 'a grid of a spacing')
    part = grid%part([0, 1, 1], [2, 2, 2], stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'part')
    part = grid
    part%spacing(2) = -1
    call part%validate(stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'spacing')
  end subroutine

  subroutine options()
    type(watcher) :: w
    type(clsdf_statistics) :: statistics
    type(clsdf_mesh) :: open_mesh
    type(clsdf_transform) :: own
    real(4) :: phi(size(expected, 1), size(expected, 2), size(expected, 3))
    real(8) :: x(3, 4)
    integer :: triangles(3, 4)
    w%progress => count_calls
    call transform%compute(grid, band, phi, options=w, statistics=statistics)
    call check(w%calls > 0 .and. statistics%slabs >= 1 .and. statistics%field_seconds > 0, 'progress and statistics')
    w%stop_after = 0
    call transform%compute(grid, band, phi, options=w, stat=stat, errmsg=errmsg)
    call fails(stat, 1234, errmsg, 'enough')
    w%progress => null()
    w%should_stop => cancel
    call transform%compute(grid, band, phi, options=w, stat=stat, errmsg=errmsg)
    call check(stat == CLSDF_CANCELLED, 'a cancelled call')
    w%should_stop => null()
    w%log => keep_message
    call tetrahedron(x, triangles)
    call open_mesh%create(x, triangles(:, :3))
    call own%create(device, open_mesh, options=w)
    call check(w%messages == 1 .and. index(w%message, 'not closed') > 0, 'a warning')
    call check(own%sign() == CLSDF_SIGN_NONE, 'a mesh without a sign')
    call marks(w)
  end subroutine

  ! What is skipped in a file, and points that are not finite.
  subroutine marks(w)
    type(watcher), intent(inout) :: w
    type(clsdf_mesh) :: edge
    type(clsdf_statistics) :: statistics
    real(8) :: points(3, 2)
    real(8) :: distance(2)
    integer :: unit
    open (newunit=unit, file='fortran_edge.obj', status='replace')
    write (unit, '(a)') 'v 0 0 0', 'v 1 0 0', 'v 0 1 0', 'f 1 2', 'f 1 2 3'
    close (unit)
    call edge%read('fortran_edge.obj', options=w)
    call check(w%messages == 2 .and. index(w%message, '1 face of fewer than three corners is skipped') > 0, 'a reading')
    points = 0
    points(1, 2) = ieee_value(1d0, ieee_quiet_nan)
    call transform%query(points, clsdf_infinity(), distance, options=w, statistics=statistics)
    call check(w%messages == 3 .and. index(w%message, '1 of 2 points has no triangle') > 0, 'a mark')
    call check(ieee_is_nan(distance(2)) .and. .not. ieee_is_nan(distance(1)), 'the distance of a mark')
    call check(statistics%unusable_points == 1, 'the number of marks')
    points(:, 2) = 0
    call transform%query(points, huge(1d0), distance, stat=stat, errmsg=errmsg)
    call check(stat == CLSDF_OK .and. distance(1) == distance(2) .and. abs(distance(1)) < 10, 'huge is no limit')
    points(1, 2) = ieee_value(1d0, ieee_quiet_nan)
    w%refuse_unusable_points = .true.
    call transform%query(points, clsdf_infinity(), distance, options=w, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'not finite')
    w%refuse_unusable_points = .false.
  end subroutine

  subroutine count_calls(options, progress, status)
    class(clsdf_call_options), intent(inout) :: options
    type(clsdf_progress), intent(in) :: progress
    integer(c_int32_t), intent(inout) :: status
    call check(progress%fraction >= 0 .and. progress%fraction <= 1, 'a fraction')
    select type (options)
    type is (watcher)
      options%calls = options%calls + 1
      if (options%stop_after > 0) return
      call clsdf_set_last_error('enough')
      status = 1234
    end select
  end subroutine

  subroutine cancel(options, status)
    class(clsdf_call_options), intent(inout) :: options
    integer(c_int32_t), intent(inout) :: status
    if (associated(options%should_stop)) status = CLSDF_CANCELLED
  end subroutine

  subroutine keep_message(options, message, status)
    class(clsdf_call_options), intent(inout) :: options
    character(*), intent(in) :: message
    integer(c_int32_t), intent(inout) :: status
    call check(status == 0, 'a status at first')
    select type (options)
    type is (watcher)
      options%messages = options%messages + 1
      options%message = message
    end select
  end subroutine

  subroutine slabs_and_fields()
    type(collector) :: all_slabs
    type(clsdf_field) :: field, own
    type(clsdf_grid) :: described, shifted
    type(clsdf_band) :: own_band
    integer(c_int32_t) :: sign
    character(:), allocatable :: name
    real(4), pointer :: phi(:, :, :), gradient(:, :, :, :)
    integer, pointer :: triangle(:, :, :)
    integer(c_int8_t), pointer :: site(:, :, :)
    allocate (all_slabs%phi, mold=expected)
    allocate (all_slabs%triangle, mold=numbers)
    call transform%compute_slabs(grid, band, all_slabs, [CLSDF_DISTANCE, CLSDF_TRIANGLE])
    call check(all_slabs%slabs >= 1 .and. all(all_slabs%phi == expected) .and. all(all_slabs%triangle == numbers), 'slabs')
    all_slabs%refuses = .true.
    call transform%compute_slabs(grid, band, all_slabs, [CLSDF_DISTANCE, CLSDF_TRIANGLE], stat=stat, errmsg=errmsg)
    call check(stat == CLSDF_CANCELLED, 'a sink that ends the call')

    shifted = grid%part([2, 3, 4], [10, 11, 12])
    call transform%compute_field(shifted, band, field, [CLSDF_DISTANCE, CLSDF_TRIANGLE, CLSDF_GRADIENT, CLSDF_SITE])
    call field%array(CLSDF_DISTANCE, phi)
    call field%array(CLSDF_TRIANGLE, triangle)
    call field%array(CLSDF_GRADIENT, gradient)
    call field%array(CLSDF_SITE, site)
    call check(all(lbound(phi) == [2, 3, 4]) .and. all(lbound(gradient) == [1, 2, 3, 4]), 'bounds of a field')
    call check(all(phi == expected(2:11, 3:13, 4:15)) .and. all(triangle == numbers(2:11, 3:13, 4:15)), 'a field')
    call check(all((site == -1) .eqv. (triangle == 0)) .and. size(gradient) == 3*size(phi), 'its other outputs')
    call field%describe(described, own_band, sign, name)
    call check(all(described%first == [2, 3, 4]) .and. own_band%inside == band%inside .and. &
        sign == CLSDF_SIGN_NONZERO .and. name /= '', 'its description')
    call check(all(field%outputs() == [CLSDF_DISTANCE, CLSDF_TRIANGLE, CLSDF_SITE, CLSDF_GRADIENT]), 'its outputs')
    own = field
    call field%release()
    call own%array(CLSDF_DISTANCE, phi)
    call check(all(phi == expected(2:11, 3:13, 4:15)), 'a copy of a field')
    call own%create(shifted, band, mesh_name='mine')
    call own%array(CLSDF_DISTANCE, phi)
    phi = 3
    call own%describe(mesh_name=name)
    call check(name == 'mine', 'an own field')
  end subroutine

  !> The surface encloses the middle of its box, and rays meet its walls from there and from afar.
  subroutine check_rays()
    type(clsdf_box) :: box
    type(clsdf_statistics) :: statistics
    real(8) :: origins(3, 2), directions(3, 2), t(2), several(4, 2)
    real(4) :: single(2), one_hit(1, 2)
    integer(c_int32_t) :: triangle(2), triangles(4, 2), counts(2)
    integer(c_int8_t) :: any_hit(2), visible(2)
    box = transform%box()
    origins(:, 1) = box%lower - 1
    origins(:, 2) = box%upper + 1
    directions(:, 1) = box%upper - box%lower
    directions(:, 2) = [0d0, 0d0, 3d0]
    call transform%rays(origins, directions, t, triangle, counts, any_hit, hits=CLSDF_FACES, statistics=statistics)
    call transform%ray_hits(origins, directions, several, triangles, hits=CLSDF_FACES)
    call check(several(1, 1) == t(1) .or. (t(1) > huge(1d0) .and. several(1, 1) > huge(1d0)), 'several hits')
    call check(triangles(1, 1) == triangle(1), 'triangles of several hits')
    call check(t(2) > huge(1d0) .and. triangle(2) == 0 .and. counts(2) == 0 .and. any_hit(2) == 0, 'a ray that misses')
    call check((counts(1) > 0) .eqv. (any_hit(1) == 1) .and. (counts(1) > 0 .eqv. triangle(1) > 0), 'counts')
    call transform%rays(real(origins, 4), real(directions, 4), single, limit=0d0)
    call check(all(single > huge(1.0)), 'the limit 0')
    call transform%ray_hits(real(origins, 4), real(directions, 4), one_hit)
    call transform%visible(origins, origins + 0.5d0*reshape([0, 0, 0, 1, 1, 1], [3, 2]), visible)
    call check(all(visible == 1), 'pairs of points')
    call transform%rays(origins, directions, t(:1), stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, '(1); give it (2)')
    call transform%visible(origins, directions, visible, hits=9, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'hits is 9')
  end subroutine

  subroutine other_calls()
    type(clsdf_transform) :: part, same, of_bytes
    integer(c_int8_t), allocatable :: bytes(:)
    integer(c_int8_t), allocatable, target :: shared(:)
    integer(c_int64_t) :: size_of_shared
    integer :: first
    type(clsdf_box) :: box
    type(clsdf_kept_memory) :: memory
    type(clsdf_topology) :: topology
    type(clsdf_device) :: of_transform
    type(clsdf_statistics) :: statistics
    integer(c_int8_t) :: places(3)
    real(8), pointer :: vertices(:, :)
    real(4) :: phi(size(expected, 1), size(expected, 2), size(expected, 3)), of_part(3, 3, 3)
    real(8), allocatable :: turned(:, :)
    integer(c_int32_t), allocatable :: own(:)
    real(8) :: winding(2)
    integer :: middle(3)
    box = transform%box()
    call transform%classify([box, clsdf_box(box%upper + 5, box%upper + 6), clsdf_box(box%lower - 1, box%upper + 1)], &
        0.01d0, places)
    call check(all(places == [CLSDF_WITHIN, CLSDF_OUTSIDE, CLSDF_WITHIN]), 'places of boxes')
    call transform%winding(reshape([box%upper + 5, box%lower - 5], [3, 2]), winding)
    call check(all(winding == 0), 'winding numbers outside')
    call transform%winding(reshape([box%upper + 5, box%lower - 5], [3, 2]), winding(:1), stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, '(1); give it (2)')
    call check_rays()
    call transform%classify([box], 0.01d0, places, stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, '(3); give it (1)')
    call transform%compile(grid, band, [CLSDF_DISTANCE], statistics=statistics)
    memory = transform%memory()
    call check(memory%host_bytes > 0, 'memory')
    topology = transform%topology()
    call check(topology%balanced .and. size(topology%first_open) == 0 .and. topology%tested_points == 0, 'topology')
    call transform%device(of_transform)
    call check(of_transform%is_set(), 'the device of a transform')

    middle = shape(expected)/2
    call transform%restrict([clsdf_region(box, 0.3d0, grid%voxel())], part)
    call part%compute(grid%part(middle, [3, 3, 3]), band, phi(:3, :3, :3))
    call check(all(phi(:3, :3, :3) == expected(middle(1):middle(1) + 2, middle(2):middle(2) + 2, &
        middle(3):middle(3) + 2)), 'a part of the domain')
    call part%part_bytes(bytes)
    call of_bytes%create_from_part(device, bytes, kept_bytes=0_8, index_base=0)
    call check(of_bytes%index_base() == 0, 'the index base of a part of bytes')
    phi(:3, :3, :3) = 0
    call of_bytes%compute(grid%part(middle, [3, 3, 3]), band, phi(:3, :3, :3))
    call check(all(phi(:3, :3, :3) == expected(middle(1):middle(1) + 2, middle(2):middle(2) + 2, &
        middle(3):middle(3) + 2)), 'a part of bytes')
    bytes(size(bytes)) = not(bytes(size(bytes)))
    call of_bytes%create_from_part(device, bytes, stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'were changed')
    call transform%part_bytes(bytes, stat, errmsg)
    call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'restrict it first')
    call part%prepared_bytes(size_of_shared, stat, errmsg)
    call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'is restricted')
    call transform%prepared_bytes(size_of_shared)
    allocate(shared(size_of_shared + 64))
    first = 65 - int(modulo(transfer(c_loc(shared), 0_c_intptr_t), 64_c_intptr_t))
    call transform%share(c_loc(shared(first)), size_of_shared)
    call of_bytes%create_from_shared(device, c_loc(shared(first)), size_of_shared)
    call check(of_bytes%index_base() == 1, 'the index base of a shared transform')
    phi(:3, :3, :3) = 0
    call of_bytes%compute(grid%part(middle, [3, 3, 3]), band, phi(:3, :3, :3))
    call check(all(phi(:3, :3, :3) == expected(middle(1):middle(1) + 2, middle(2):middle(2) + 2, &
        middle(3):middle(3) + 2)), 'a shared transform')
    call of_bytes%release()
    shared(first + 2000) = not(shared(first + 2000))
    call of_bytes%create_from_shared(device, c_loc(shared(first)), size_of_shared, stat, errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'was changed')

    ! A part whose vertices move by up to 0.1.
    call transform%restrict([clsdf_region(box, 0.3d0, grid%voxel())], part, margin=0.1d0)
    call part%part_vertices(own)
    call mesh%vertices(vertices)
    turned = vertices
    turned(2, :) = turned(2, :) + 0.09d0*sin(3*vertices(1, :))
    call same%create(device, mesh)
    call same%set_positions(turned)
    call part%set_positions(turned(:, own))
    call same%compute(grid%part(middle, [3, 3, 3]), band, phi(:3, :3, :3))
    call part%compute(grid%part(middle, [3, 3, 3]), band, of_part)
    call check(all(phi(:3, :3, :3) == of_part), 'a part that has moved')
    call part%set_positions(turned(:, own) + 1, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'the margin 0.1')
    call part%part_vertices(own)
    call of_bytes%part_vertices(own, stat, errmsg)
    call check(stat /= 0, 'vertices of no part')

    ! A quarter turn: columns of the rotation are images of the axes.
    call same%create(device, mesh)
    call same%set_motion(reshape([0d0, 1d0, 0d0, -1d0, 0d0, 0d0, 0d0, 0d0, 1d0], [3, 3]), [1d0, 2d0, 3d0])
    call mesh%vertices(vertices)
    box = same%box()
    call check(abs(box%upper(1) - (1 - minval(vertices(2, :)))) < 1d-9, 'a motion along x')
    call check(abs(box%upper(2) - (2 + maxval(vertices(1, :)))) < 1d-9, 'a motion along y')
    call same%set_positions(2*vertices)
    box = same%box()
    call check(abs(box%upper(3) - 2*maxval(vertices(3, :))) < 1d-9, 'new positions')
    call same%set_positions(transpose(real(vertices, 4)))
    box = same%box()
    call check(abs(box%upper(3) - maxval(vertices(3, :))) < 1d-6, 'new positions (n, 3)')
    call transform%compute(grid, clsdf_band_signs_only(), phi)
    call check(all((sign(1.0, phi) < 0) .eqv. (sign(1.0, expected) < 0)), 'signs only')
    call transform%compute(grid, clsdf_band(0, 0, 1, 1), phi)
    call check(all((phi < 0) .eqv. (expected < 0)) .and. any(phi < 0), 'exact signs only')
    call transform%compute(grid, clsdf_band_full(), phi)
    call check(maxval(phi) > 0.3 .and. clsdf_infinity() > huge(1d0), 'a full band')
  end subroutine

  subroutine errors()
    type(clsdf_transform) :: none
    type(clsdf_grid) :: wrong
    real(4) :: phi(size(expected, 1), size(expected, 2), size(expected, 3))
    character(10) :: short
    errmsg = 'as before'
    call transform%compute(grid, band, phi, stat=stat, errmsg=errmsg)
    call check(stat == 0 .and. errmsg == 'as before', 'errmsg is defined after an error alone')
    call check(clsdf_last_error() == '', 'no message after a success')
    call none%compute(grid, band, phi, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'transform is null')
    wrong = grid
    wrong%spacing(2) = -0.5d0
    call transform%compute(wrong, band, phi, stat=stat, errmsg=short)
    call check(stat == CLSDF_INVALID_ARGUMENT .and. len_trim(short) > 0, 'a short errmsg')
    call check(index(clsdf_last_error(), 'spacing along y is -0.5') > 0, 'the whole message')
    call check(clsdf_last_opencl_error() == 0, 'no error of OpenCL')
    call transform%compute(grid, clsdf_band(0, 0), phi, stat=stat)
    call check(stat == CLSDF_INVALID_ARGUMENT, 'stat alone')
    call transform%compute(grid, band, [clsdf_target(77, clsdf_array(phi))], stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, '77')
  end subroutine

end program
