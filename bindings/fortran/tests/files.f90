! Files of fields and points.
program files
  use, intrinsic :: iso_c_binding
  use clsdf
  use clsdf_io
  use test
  implicit none
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: grid, other_grid
  type(clsdf_band) :: band
  type(clsdf_field) :: field, other
  type(clsdf_field_writer) :: writer, copy
  type(clsdf_sparse_field) :: sparse
  type(clsdf_sparse_field) :: read_sparse
  type(clsdf_sparse_slab) :: slab, read_slab
  integer(c_int32_t), pointer :: triangles_of_slab(:, :, :, :), triangles_of_file(:, :, :, :)
  type(clsdf_sparse_writer) :: sparse_writer, sparse_copy
  real(4), allocatable, target :: expected(:, :, :), vectors(:, :, :, :), last(:, :, :, :)
  integer, allocatable, target :: numbers(:, :, :), bodies(:, :, :)
  real(4), pointer :: phi(:, :, :), gradient(:, :, :, :)
  integer, pointer :: triangle(:, :, :)
  real(8), allocatable :: points(:, :)
  real(8) :: floor
  real(4), target :: d(2), g(3, 2), turned(2, 3), row(7)
  character(:), allocatable :: text
  integer :: stat, half, file
  character(300) :: errmsg
  logical :: is_there

  call device%automatic()
  call mesh%shape('knot')
  call transform%create(device, mesh)
  band = clsdf_band_symmetric(0.2d0)
  call grid%around(mesh, 24, band)
  allocate (expected(grid%size(1), grid%size(2), grid%size(3)), numbers(grid%size(1), grid%size(2), grid%size(3)))
  allocate (vectors(3, grid%size(1), grid%size(2), grid%size(3)))
  call transform%compute(grid, band, expected, triangle=numbers, gradient=vectors)

  ! A field of the library, and its triangles, from 1 on both ways.
  call transform%compute_field(grid, band, field, [CLSDF_DISTANCE, CLSDF_TRIANGLE])
  call clsdf_field_check_path('fortran_field.h5', [CLSDF_DISTANCE, CLSDF_TRIANGLE])
  call clsdf_field_write(field, 'fortran_field.h5')
  call read_back('fortran_field.h5', 'a field')
  call clsdf_field_write(other, 'fortran_field.h5')
  call read_back('fortran_field.h5', 'a field that was read')
  call clsdf_field_missing_files('fortran_field.h5', text)
  call check(text == '', 'no missing file')

  ! A field of the program's own values.
  call other%create(grid, band, outputs=[CLSDF_DISTANCE, CLSDF_TRIANGLE])
  call other%array(CLSDF_DISTANCE, phi)
  call other%array(CLSDF_TRIANGLE, triangle)
  phi = expected
  triangle = numbers
  call clsdf_field_write(other, 'fortran_own.h5')
  call read_back('fortran_own.h5', 'an own field')

  ! A file states the floor of a field, whoever made it.
  call other%create(grid, band, CLSDF_SIGN_BELOW, floor=-0.5d0)
  call other%array(CLSDF_DISTANCE, phi)
  phi = expected
  call clsdf_field_write(other, 'fortran_floor.nrrd')
  call clsdf_field_read('fortran_floor.nrrd', other)
  call other%describe(sign=stat, floor=floor)
  call check(stat == CLSDF_SIGN_BELOW .and. floor == -0.5d0, 'the floor of a field')
  call writer%create('fortran_floor.h5', grid, band, CLSDF_SIGN_BELOW, floor=-0.25d0)
  call transform%compute_slabs(grid, band, writer)
  call writer%finish()
  call clsdf_field_read('fortran_floor.h5', other)
  call other%describe(floor=floor)
  call check(floor == -0.25d0, 'the floor of slabs')
  call writer%create('fortran_floor.h5', grid, band, floor=-0.25d0, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'sign rule below')

  ! Slabs of a call into a file.
  call writer%create('fortran_slabs.h5', grid, band, transform%sign(), 'knot', [CLSDF_DISTANCE, CLSDF_TRIANGLE])
  copy = writer
  call transform%compute_slabs(grid, band, writer, [CLSDF_DISTANCE, CLSDF_TRIANGLE])
  call copy%finish()
  call read_back('fortran_slabs.h5', 'slabs')
  call other%describe(mesh_name=text)
  call check(text == 'knot', 'the name of the mesh')

  ! Slabs of a transform whose triangles count from 0: those in files always do.
  call mesh%set_index_base(0)
  call transform%create(device, mesh)
  call writer%create('fortran_from_0.h5', grid, band, outputs=[CLSDF_DISTANCE, CLSDF_TRIANGLE])
  call transform%compute_slabs(grid, band, writer, [CLSDF_DISTANCE, CLSDF_TRIANGLE])
  call writer%finish()
  call read_back('fortran_from_0.h5', 'slabs with triangles from 0')

  ! Slices of the program.
  half = size(expected, 3)/2
  call writer%create('fortran_slices.nrrd', grid, band, outputs=[CLSDF_DISTANCE, CLSDF_TRIANGLE, CLSDF_GRADIENT])
  call writer%append([clsdf_target(CLSDF_DISTANCE, expected(:, :, :half)), &
      clsdf_target(CLSDF_TRIANGLE, numbers(:, :, :half)), clsdf_target(CLSDF_GRADIENT, vectors(:, :, :, :half))])
  call writer%append([clsdf_target(CLSDF_DISTANCE, expected(:, :, half + 1:)), &
      clsdf_target(CLSDF_TRIANGLE, numbers(:, :, half + 1:)), clsdf_target(CLSDF_GRADIENT, vectors(:, :, :, half + 1:))])
  call writer%finish()
  call read_back('fortran_slices.nrrd', 'slices')
  call other%array(CLSDF_GRADIENT, gradient)
  call check(all(gradient == vectors .or. spread(numbers == 0, 1, 3)), 'slices: the gradients')

  ! Bodies, from 1 on both ways.
  bodies = min(numbers, 2)
  call writer%create('fortran_bodies.h5', grid, band, outputs=[CLSDF_DISTANCE, CLSDF_BODY])
  call writer%append([clsdf_target(CLSDF_DISTANCE, expected), clsdf_target(CLSDF_BODY, bodies)])
  call writer%finish()
  call clsdf_field_read('fortran_bodies.h5', other)
  call other%array(CLSDF_BODY, triangle)
  call check(all(triangle == bodies), 'bodies')

  ! Without finish() there is no file.
  call writer%create('fortran_never.nrrd', grid, band)
  call writer%append([clsdf_target(CLSDF_DISTANCE, expected(::2, :, :))], stat, errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'distance is not packed')
  call writer%append([clsdf_target(CLSDF_DISTANCE, real(expected, 8))], stat, errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'double')
  call writer%release()
  call writer%create('fortran_never.nrrd', grid, band, outputs=[CLSDF_DISTANCE, CLSDF_GRADIENT])
  last = reshape(vectors, [shape(expected), 3])
  call writer%append([clsdf_target(CLSDF_DISTANCE, expected), clsdf_target(CLSDF_GRADIENT, last)], stat, errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'gradient is not packed, with components first')
  call writer%release()
  inquire (file='fortran_never.nrrd', exist=is_there)
  call check(.not. is_there, 'no file without finish()')

  ! With groups a .vti has the group of each sample, four bytes.
  block
    integer(8) :: before, after
    integer, allocatable :: t(:, :)
    call mesh%triangles(t)
    call clsdf_field_write(field, 'fortran_groups.vti')
    inquire (file='fortran_groups.vti', size=before)
    call mesh%set_groups([character(5) :: 'inlet', 'wall'], [2, spread(1, 1, size(t, 2) - 1)])
    call field%set_groups(mesh)
    call clsdf_field_write(field, 'fortran_groups.vti')
    inquire (file='fortran_groups.vti', size=after)
    call check(after > before + 4*grid%sample_count() .and. after < before + 4*grid%sample_count() + 500, 'groups of samples')
  end block

  call clsdf_field_check_path('fortran_field.xyz', stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'fortran_field.xyz')
  call clsdf_field_read('no such field.nrrd', other, stat, errmsg)
  call fails(stat, CLSDF_UNREADABLE_INPUT, errmsg, 'no such field')
  call check(.not. other%is_set(), 'a field after an error')

  ! Sparse fields, in one piece and in layers.
  call transform%compute_sparse_field(grid, band, sparse)
  call clsdf_sparse_field_write(sparse, 'fortran_sparse.nvdb')
  call check_nvdb('fortran_sparse.nvdb')
  call sparse_writer%create('fortran_layers.nvdb', grid, band, transform%sign(), 'knot')
  sparse_copy = sparse_writer
  call transform%compute_sparse_slabs(grid, band, sparse_writer)
  call sparse_copy%finish()
  call check_nvdb('fortran_layers.nvdb')
  call sparse_writer%create('fortran_layer.nvdb', grid, band)
  call sparse%slab(slab)
  call sparse_writer%append(slab)
  call sparse_writer%finish()
  call check_nvdb('fortran_layer.nvdb')
  call sparse_writer%create('fortran_sparse_never.nvdb', grid, band)
  call sparse_writer%finish(stat, errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'missing')
  ! A written sparse field is read as one; a dense field is none.
  call transform%compute_sparse_field(grid, band, sparse, [CLSDF_TRIANGLE])
  call clsdf_sparse_field_write(sparse, 'fortran_sparse.npy')
  call sparse%slab(slab)
  call clsdf_sparse_field_read('fortran_sparse.npy', read_sparse)
  call read_sparse%slab(read_slab)
  call slab%array(CLSDF_TRIANGLE, triangles_of_slab)
  call read_slab%array(CLSDF_TRIANGLE, triangles_of_file)
  call check(all(read_slab%bricks() == slab%bricks()), 'bricks of a file')
  call check(all(triangles_of_file == triangles_of_slab + 1), 'triangles of a sparse file, from 1')
  call clsdf_field_write(field, 'fortran_dense.npy')
  call clsdf_sparse_field_read('fortran_dense.npy', read_sparse)
  call check(.not. read_sparse%is_set(), 'a dense file')
  call clsdf_sparse_field_read('fortran_missing.npy', read_sparse, stat, errmsg)
  call fails(stat, CLSDF_UNREADABLE_INPUT, errmsg, 'fortran_missing.npy')
  call clsdf_sparse_field_write(sparse, 'fortran_sparse.nrrd', stat, errmsg)
  call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'stores no sparse fields')

  ! Points.
  d = [1.5, -2.25]
  call clsdf_points_write(reshape([1d0, 2d0, 3d0, 4d0, 5d0, 6d0], [3, 2]), [clsdf_target(CLSDF_DISTANCE, d)], &
      'fortran_points.csv')
  call clsdf_points_read('fortran_points.csv', points)
  call check(all(points == reshape([1d0, 2d0, 3d0, 4d0, 5d0, 6d0], [3, 2])), 'points')
  g = reshape([0.5, 1.0, 2.0, 4.0, 8.0, 16.0], [3, 2])
  call clsdf_points_write(reshape([1d0, 2d0, 3d0, 4d0, 5d0, 6d0], [3, 2]), [clsdf_target(CLSDF_DISTANCE, d), &
      clsdf_target(CLSDF_GRADIENT, g)], 'fortran_points.csv')
  open (newunit=file, file='fortran_points.csv', action='read')
  read (file, '(//)', advance='no')
  read (file, *) row
  close (file)
  call check(all(row == [4.0, 5.0, 6.0, d(2), g(:, 2)]), 'gradients at points')
  turned = transpose(g)
  call clsdf_points_write(reshape([1d0, 2d0, 3d0, 4d0, 5d0, 6d0], [3, 2]), [clsdf_target(CLSDF_DISTANCE, d), &
      clsdf_target(CLSDF_GRADIENT, turned)], 'fortran_points.csv', stat, errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'gradient is not packed, with components first')
  call clsdf_points_write(points(:, 1:0), [clsdf_target(CLSDF_DISTANCE, d(1:0))], 'fortran_no_points.csv')
  call clsdf_points_read('fortran_no_points.csv', points)
  call check(size(points) == 0, 'no points')
  call clsdf_points_check_path('fortran_points.xyz', stat, errmsg)
  call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'fortran_points.xyz')
  call clsdf_io_abandon_unfinished_files()

contains

  subroutine read_back(path, what)
    character(*), intent(in) :: path, what
    call clsdf_field_read(path, other)
    call other%describe(other_grid)
    call other%array(CLSDF_DISTANCE, phi)
    call other%array(CLSDF_TRIANGLE, triangle)
    call check(all(other_grid%first == grid%first) .and. all(other_grid%size == grid%size), what//': the grid')
    call check(all(phi == expected) .and. all(triangle == numbers), what//': the values')
  end subroutine

  subroutine check_nvdb(path)
    character(*), intent(in) :: path
    call clsdf_field_read(path, other)
    call other%describe(other_grid)
    call other%array(CLSDF_DISTANCE, phi)
    call check(all(other_grid%size == grid%size), path//': the grid')
    call check(all(phi == expected), path//': the values')
  end subroutine

end program
