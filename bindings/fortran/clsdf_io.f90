!> Files of fields for clsdf in Fortran 2008: on libclsdf_c_io, which links HDF5. A program with an HDF5 of its own uses
!> the module clsdf alone. The rules of clsdf.f90 hold.
module clsdf_io
  use, intrinsic :: iso_c_binding
  use clsdf_c
  use clsdf
  implicit none
  private
  public :: clsdf_field_read, clsdf_field_missing_files, clsdf_field_write, clsdf_field_check_path, clsdf_field_writer, &
      clsdf_sparse_field_read, clsdf_sparse_field_write, clsdf_sparse_writer, clsdf_io_abandon_unfinished_files

  !> Writes a field slab by slab, from the caller's arrays; or, as a sink of transform%compute_slabs(), from that call.
  type, extends(clsdf_slab_sink) :: clsdf_field_writer
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure :: create => writer_create
    procedure :: append => writer_append
    procedure :: take => writer_take
    procedure :: finish => writer_finish
    procedure :: release => writer_release
    procedure, private :: writer_assign
    generic :: assignment(=) => writer_assign
    final :: writer_end
  end type

  !> The same of a sparse field, into a .nvdb, .npy, .h5 or, if OpenVDB is built in, .vdb: layer by layer, or as a sink
  !> of transform%compute_sparse_slabs().
  type, extends(clsdf_sparse_sink) :: clsdf_sparse_writer
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure :: create => sparse_writer_create
    procedure :: append => sparse_writer_append
    procedure :: take_sparse => sparse_writer_take
    procedure :: finish => sparse_writer_finish
    procedure :: release => sparse_writer_release
    procedure, private :: sparse_writer_assign
    generic :: assignment(=) => sparse_writer_assign
    final :: sparse_writer_end
  end type

contains

  !> Reads a field: .nrrd, .npy, .vti, .vtkhdf, .h5, .nvdb, .sdf or, if OpenVDB is built in, .vdb. Its
  !> triangles count from 1.
  subroutine clsdf_field_read(path, field, stat, errmsg)
    character(*), intent(in) :: path
    type(clsdf_field), intent(inout) :: field
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: status
    call field%release()
    status = c_field_read(trim(path)//c_null_char, field%handle)
    if (status == CLSDF_OK) status = c_field_set_index_base(field%handle, 1_c_int32_t)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> The files of outputs that the field's file names but that do not exist, one a line.
  subroutine clsdf_field_missing_files(path, files, stat, errmsg)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: files
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    character(kind=c_char), allocatable, target :: text(:)
    integer(c_int64_t) :: length, written
    integer(c_int32_t) :: status
    files = ''
    status = c_field_missing_files(trim(path)//c_null_char, c_null_ptr, 0_c_int64_t, length)
    if (status == CLSDF_OK) then
      allocate (text(length + 1))
      status = c_field_missing_files(trim(path)//c_null_char, c_loc(text), length + 1, written)
      files = clsdf_text(c_loc(text))
    end if
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Writes by the file's ending, complete or not at all.
  subroutine clsdf_field_write(field, path, stat, errmsg)
    type(clsdf_field), intent(in) :: field
    character(*), intent(in) :: path
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_field_write(field%handle, trim(path)//c_null_char), stat, errmsg)
  end subroutine

  !> The error that clsdf_field_write() would give for the ending, the outputs or the folder. Leaves no file.
  subroutine clsdf_field_check_path(path, outputs, stat, errmsg)
    character(*), intent(in) :: path
    integer(c_int32_t), intent(in), optional :: outputs(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_field_check_path(trim(path)//c_null_char, clsdf_outputs_mask(outputs)), stat, errmsg)
  end subroutine

  !> floor: of CLSDF_SIGN_BELOW, its z, which the file states.
  subroutine writer_create(self, path, grid, band, sign, mesh_name, outputs, positive_inside, stat, errmsg, floor)
    class(clsdf_field_writer), intent(inout) :: self
    character(*), intent(in) :: path
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    integer(c_int32_t), intent(in), optional :: sign
    character(*), intent(in), optional :: mesh_name
    integer(c_int32_t), intent(in), optional :: outputs(:)
    logical, intent(in), optional :: positive_inside
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), intent(in), optional :: floor
    type(clsdf_c_description) :: c
    character(:), allocatable, target :: text
    call self%release()
    call describe(grid, band, sign, mesh_name, positive_inside, floor, c, text)
    c%mesh_name = c_loc(text)
    call clsdf_finish(c_field_writer_create(trim(path)//c_null_char, c, clsdf_outputs_mask(outputs), self%handle), &
        stat, errmsg)
  end subroutine

  !> text: the name, for c%mesh_name.
  subroutine describe(grid, band, sign, mesh_name, positive_inside, floor, c, text)
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    integer(c_int32_t), intent(in), optional :: sign
    character(*), intent(in), optional :: mesh_name
    logical, intent(in), optional :: positive_inside
    real(c_double), intent(in), optional :: floor
    type(clsdf_c_description), intent(out) :: c
    character(:), allocatable, intent(out) :: text
    c%struct_size = c_sizeof(c)
    c%grid = clsdf_grid_for_c(grid)
    c%band = band
    if (present(sign)) c%sign = sign
    if (present(positive_inside)) c%positive_inside = merge(1, 0, positive_inside)
    if (present(floor)) c%floor = floor
    text = c_null_char
    if (present(mesh_name)) text = trim(mesh_name)//c_null_char
  end subroutine

  !> The next slices, size(array, 3) of the distance, in ascending z: packed arrays of the announced outputs and of the
  !> types that clsdf_output_describe() states, components first. Triangles count from 1.
  subroutine writer_append(self, values, stat, errmsg)
    class(clsdf_field_writer), intent(inout) :: self
    type(clsdf_target), intent(in) :: values(:)
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    type(clsdf_c_target), target :: c(size(values))
    integer(c_int64_t) :: items(3)
    integer(c_int32_t) :: status
    integer :: i
    status = CLSDF_OK
    items = 0
    do i = 1, size(values)
      if (values(i)%output == CLSDF_DISTANCE) items = values(i)%array%shape(1:3)
    end do
    call clsdf_targets_of_samples(values, items, 3, c, status)
    do i = 1, size(values)
      if (status /= CLSDF_OK) exit
      call clsdf_pack_for_c(values(i)%array, product(items), c(i), status)
    end do
    if (status == CLSDF_OK) call append(self, c, items(3), 1_c_int32_t, status)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  subroutine writer_take(sink, slab, status)
    class(clsdf_field_writer), intent(inout) :: sink
    type(clsdf_slab), intent(in) :: slab
    integer(c_int32_t), intent(inout) :: status
    type(clsdf_c_target), pointer :: values(:)
    call c_f_pointer(slab%values, values, [slab%count])
    call append(sink, values, slab%part%size(3), slab%index_base, status)
  end subroutine

  !> Triangles in files count from 0: if those of `values` count from 1, a copy of them does.
  subroutine append(self, values, slices, index_base, status)
    class(clsdf_field_writer), intent(inout) :: self
    type(clsdf_c_target), intent(in) :: values(:)
    integer(c_int64_t), intent(in) :: slices
    integer(c_int32_t), intent(in) :: index_base
    integer(c_int32_t), intent(inout) :: status
    type(clsdf_c_target) :: from_0(size(values))
    integer(c_int32_t), allocatable, target :: triangles(:), bodies(:)
    from_0 = values
    call count_from_0(from_0, index_base, triangles, bodies)
    status = c_field_writer_append(self%handle, from_0, size(values, kind=c_int64_t), slices)
  end subroutine

  !> triangles, bodies: the copies, if they are made.
  subroutine count_from_0(values, index_base, triangles, bodies)
    type(clsdf_c_target), intent(inout) :: values(:)
    integer(c_int32_t), intent(in) :: index_base
    integer(c_int32_t), allocatable, target, intent(out) :: triangles(:), bodies(:)
    if (index_base /= 1) return
    call copy_from_0(values, CLSDF_TRIANGLE, triangles)
    call copy_from_0(values, CLSDF_BODY, bodies)
  end subroutine

  subroutine copy_from_0(values, output, numbers)
    type(clsdf_c_target), intent(inout) :: values(:)
    integer(c_int32_t), intent(in) :: output
    integer(c_int32_t), allocatable, target, intent(inout) :: numbers(:)
    integer(c_int32_t), pointer :: given(:)
    integer :: i
    ! C takes the last of several, and refuses other types and memory of the device.
    i = findloc(values%output == output .and. values%array%type == CLSDF_UINT32, .true., dim=1, back=.true.)
    if (i == 0) return
    if (.not. c_associated(values(i)%array%host)) return
    call c_f_pointer(values(i)%array%host, given, [values(i)%array%count])
    allocate (numbers(values(i)%array%count))
    numbers = given - 1
    values(i)%array%host = c_loc(numbers)
  end subroutine

  !> Gives the files their names.
  subroutine writer_finish(self, stat, errmsg)
    class(clsdf_field_writer), intent(inout) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_field_writer_finish(self%handle), stat, errmsg)
  end subroutine

  !> The last release without finish() leaves no file.
  subroutine writer_release(self)
    class(clsdf_field_writer), intent(inout) :: self
    call c_field_writer_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine writer_assign(left, right)
    class(clsdf_field_writer), intent(inout) :: left
    type(clsdf_field_writer), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_field_writer_retain(right%handle)
    left%handle = right%handle
    call c_field_writer_release(before)
  end subroutine

  impure elemental subroutine writer_end(self)
    type(clsdf_field_writer), intent(inout) :: self
    call self%release()
  end subroutine

  !> Reads a .nvdb, .npy, .h5 or, if OpenVDB is built in, .vdb as a sparse field, whose triangles count from 1. The field
  !> is not set if the file has a dense one, which clsdf_field_read() reads.
  subroutine clsdf_sparse_field_read(path, field, stat, errmsg)
    character(*), intent(in) :: path
    type(clsdf_sparse_field), intent(inout) :: field
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: status
    call field%release()
    status = c_sparse_field_read(trim(path)//c_null_char, field%handle)
    if (status /= CLSDF_OK .or. .not. field%is_set()) then
      call clsdf_finish(status, stat, errmsg)
    else
      call field%set_index_base(1_c_int32_t, stat, errmsg)
    end if
  end subroutine

  !> Writes a .nvdb, .npy, .h5 or, if OpenVDB is built in, .vdb, complete or not at all.
  subroutine clsdf_sparse_field_write(field, path, stat, errmsg)
    type(clsdf_sparse_field), intent(in) :: field
    character(*), intent(in) :: path
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_sparse_field_write(field%handle, trim(path)//c_null_char), stat, errmsg)
  end subroutine

  !> floor: of CLSDF_SIGN_BELOW, its z, which the file states.
  subroutine sparse_writer_create(self, path, grid, band, sign, mesh_name, outputs, positive_inside, stat, errmsg, floor)
    class(clsdf_sparse_writer), intent(inout) :: self
    character(*), intent(in) :: path
    type(clsdf_grid), intent(in) :: grid
    type(clsdf_band), intent(in) :: band
    integer(c_int32_t), intent(in), optional :: sign
    character(*), intent(in), optional :: mesh_name
    integer(c_int32_t), intent(in), optional :: outputs(:)
    logical, intent(in), optional :: positive_inside
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    real(c_double), intent(in), optional :: floor
    type(clsdf_c_description) :: c
    character(:), allocatable, target :: text
    call self%release()
    call describe(grid, band, sign, mesh_name, positive_inside, floor, c, text)
    c%mesh_name = c_loc(text)
    call clsdf_finish(c_sparse_writer_create(trim(path)//c_null_char, c, clsdf_outputs_mask(outputs), self%handle), &
        stat, errmsg)
  end subroutine

  !> The next layers, in ascending z.
  subroutine sparse_writer_append(self, slab, stat, errmsg)
    class(clsdf_sparse_writer), intent(inout) :: self
    type(clsdf_sparse_slab), intent(in) :: slab
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    integer(c_int32_t) :: status
    status = CLSDF_OK
    call self%take_sparse(slab, status)
    call clsdf_finish(status, stat, errmsg)
  end subroutine

  !> Triangles and bodies in files count from 0.
  subroutine sparse_writer_take(sink, slab, status)
    class(clsdf_sparse_writer), intent(inout) :: sink
    type(clsdf_sparse_slab), intent(in) :: slab
    integer(c_int32_t), intent(inout) :: status
    type(clsdf_c_sparse_slab) :: c
    type(clsdf_c_target), allocatable, target :: from_0(:)
    type(clsdf_c_target), pointer :: values(:)
    integer(c_int32_t), allocatable, target :: triangles(:), bodies(:)
    c = slab%c
    if (c%values%count > 0) then
      call c_f_pointer(c%values%items, values, [c%values%count])
      from_0 = values
      call count_from_0(from_0, slab%index_base, triangles, bodies)
      c%values%items = c_loc(from_0)
    end if
    status = c_sparse_writer_append(sink%handle, c)
  end subroutine

  !> Gives the file its name.
  subroutine sparse_writer_finish(self, stat, errmsg)
    class(clsdf_sparse_writer), intent(inout) :: self
    integer, intent(out), optional :: stat
    character(*), intent(inout), optional :: errmsg
    call clsdf_finish(c_sparse_writer_finish(self%handle), stat, errmsg)
  end subroutine

  !> The last release without finish() leaves no file.
  subroutine sparse_writer_release(self)
    class(clsdf_sparse_writer), intent(inout) :: self
    call c_sparse_writer_release(self%handle)
    self%handle = c_null_ptr
  end subroutine

  impure elemental subroutine sparse_writer_assign(left, right)
    class(clsdf_sparse_writer), intent(inout) :: left
    type(clsdf_sparse_writer), intent(in) :: right
    type(c_ptr) :: before
    before = left%handle
    call c_sparse_writer_retain(right%handle)
    left%handle = right%handle
    call c_sparse_writer_release(before)
  end subroutine

  impure elemental subroutine sparse_writer_end(self)
    type(clsdf_sparse_writer), intent(inout) :: self
    call self%release()
  end subroutine

  !> For a program that is about to end: removes the unfinished files of all threads, those of the module clsdf included.
  subroutine clsdf_io_abandon_unfinished_files()
    call c_io_abandon_unfinished_files()
  end subroutine

end module
