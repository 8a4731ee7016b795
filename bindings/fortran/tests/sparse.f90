! A sparse field has the values of the dense one, in arrays of the program, in layers and in memory of the library.
module sparse_collectors
  use, intrinsic :: iso_c_binding
  use clsdf
  use test
  implicit none
  type, extends(clsdf_sparse_sink) :: collector
    type(clsdf_sparse_counts) :: counts
    real(8) :: sum = 0
    integer(8) :: next_z = 0
    logical :: refuses = .false.
  contains
    procedure :: take_sparse
  end type
contains

  subroutine take_sparse(sink, slab, status)
    class(collector), intent(inout) :: sink
    type(clsdf_sparse_slab), intent(in) :: slab
    integer(c_int32_t), intent(inout) :: status
    real(4), pointer :: phi(:, :, :, :)
    if (sink%refuses) then
      call clsdf_set_last_error('enough bricks')
      status = CLSDF_CANCELLED
      return
    end if
    call check(slab%part%first(3) == sink%next_z, 'the order of layers')
    sink%next_z = sink%next_z + slab%part%size(3)
    sink%counts%bricks = sink%counts%bricks + slab%brick_count
    sink%counts%runs = sink%counts%runs + slab%run_count
    if (slab%brick_count == 0) return
    call slab%array(CLSDF_DISTANCE, phi)
    sink%sum = sink%sum + sum(real(phi, 8))
  end subroutine

end module

program sparse
  use, intrinsic :: iso_c_binding
  use clsdf
  use sparse_collectors
  use test
  implicit none
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: grid, whole, other_grid
  type(clsdf_band) :: band
  type(clsdf_statistics) :: statistics
  type(clsdf_sparse_counts) :: counts, found
  type(clsdf_sparse_field) :: field, copy
  type(clsdf_sparse_field), allocatable :: fields(:)
  type(clsdf_sparse_request) :: requests(2)
  type(clsdf_sparse_slab) :: slab
  type(collector) :: sink
  real(4), allocatable :: expected(:, :, :), vectors(:, :, :, :), distances(:)
  integer, allocatable :: numbers(:, :, :)
  integer(8), allocatable, target :: bricks(:, :), inside(:, :), samples(:, :)
  real(4), allocatable, target :: phi(:, :, :, :), gradient(:, :, :, :, :)
  integer, allocatable, target :: triangle(:, :, :, :)
  real(4), pointer :: values(:, :, :, :), directions(:, :, :, :, :)
  real(8), pointer :: doubles(:, :, :, :, :)
  integer, pointer :: triangles(:, :, :, :)
  character(:), allocatable :: name
  character(300) :: errmsg
  character(80) :: words
  integer(8) :: number, i, j, k, at
  integer :: stat

  call device%automatic()
  call mesh%shape('sphere3')
  call transform%create(device, mesh)
  band = clsdf_band_symmetric(0.05d0)
  call grid%around(mesh, 48, band)
  grid%origin(1) = grid%origin(1) + 6*grid%spacing(1)
  grid%first(1) = -5
  grid%size(1) = grid%size(1) + 8
  whole = grid%in_whole_bricks()
  call check(whole%first(1) == -7 .and. all(mod(whole%first - 1, 8_8) == 0) .and. all(mod(whole%size, 8_8) == 0), 'bricks')
  allocate (expected(whole%size(1), whole%size(2), whole%size(3)), numbers(whole%size(1), whole%size(2), whole%size(3)))
  allocate (vectors(3, whole%size(1), whole%size(2), whole%size(3)))
  call transform%compute(whole, band, expected, triangle=numbers, gradient=vectors)

  ! Arrays of the program.
  call transform%count_sparse(grid, band, counts, statistics=statistics)
  call check(counts%bricks > 20 .and. counts%runs > 2 .and. statistics%slabs == 1, 'counts')
  allocate (bricks(3, counts%bricks), inside(4, counts%runs), phi(8, 8, 8, counts%bricks))
  allocate (triangle(8, 8, 8, counts%bricks), gradient(3, 8, 8, 8, counts%bricks))
  call transform%compute_sparse(grid, band, bricks, inside, [clsdf_target(CLSDF_DISTANCE, phi), &
      clsdf_target(CLSDF_TRIANGLE, triangle), clsdf_target(CLSDF_GRADIENT, gradient)], found)
  call check(found%bricks == counts%bricks .and. found%runs == counts%runs, 'counts of the call')
  do at = 1, counts%bricks
    call check(all(mod(bricks(:, at) - 1, 8_8) == 0), 'places of bricks')
    do k = 1, 8
      do j = 1, 8
        do i = 1, 8
          call check(phi(i, j, k, at) == dense(bricks(:, at) + [i, j, k] - 1), 'distances of a brick')
          call check(triangle(i, j, k, at) == number_at(bricks(:, at) + [i, j, k] - 1), 'triangles of a brick')
          if (triangle(i, j, k, at) > 0) call check(all(gradient(:, i, j, k, at) == vector_at(bricks(:, at) + [i, j, k] - 1)), &
              'gradients of a brick')
        end do
      end do
    end do
  end do
  do at = 1, counts%runs
    do i = 0, inside(4, at) - 1
      call check(dense(inside(:3, at) + [8*i, 0_8, 0_8]) == -0.05, 'a brick inside')
    end do
  end do

  ! Too little room.
  write (words, '(2(a, i0))') 'has ', counts%bricks, ' bricks with values and ', counts%runs
  phi = -7
  call transform%compute_sparse(grid, band, bricks(:, 2:), inside, phi(:, :, :, :counts%bricks - 1), found, stat=stat, &
      errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, trim(words))
  call check(found%bricks == counts%bricks .and. all(phi(:, :, :, counts%bricks) == -7), 'too little room')
  call transform%compute_sparse(grid, band, bricks, inside, phi, found)
  call check(all(phi(:, :, :, 1) == reshape([(((dense(bricks(:, 1) + [i, j, k]), i=0, 7), j=0, 7), k=0, 7)], [8, 8, 8])), &
      'the distance alone')
  call transform%compute_sparse(grid, band, bricks, inside, phi(:, :, :, 2:), found, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'has the shape')
  call transform%compute_sparse(grid, band, inside, bricks, phi, found, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'give them (3, n) and (4, n)')
  call transform%compute_sparse(grid, clsdf_band_full(), bricks, inside, phi, found, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'band with an end')
  call transform%count_sparse(grid, clsdf_band_full(), found, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'band with an end')

  ! Layers.
  sink%next_z = whole%first(3)
  call transform%compute_sparse_slabs(grid, band, sink)
  call check(sink%next_z == whole%first(3) + whole%size(3), 'all layers')
  call check(sink%counts%bricks == counts%bricks .and. sink%counts%runs == counts%runs, 'bricks of layers')
  call check(sink%sum == sum(real(phi, 8)), 'values of layers')
  sink%refuses = .true.
  call transform%compute_sparse_slabs(grid, band, sink, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_CANCELLED, errmsg, 'enough bricks')

  ! Memory of the library.
  call transform%compute_sparse_field(grid, band, field, [CLSDF_DISTANCE, CLSDF_TRIANGLE, CLSDF_GRADIENT, CLSDF_CLOSEST])
  copy = field
  call field%release()
  call check(copy%is_set() .and. .not. field%is_set(), 'references')
  call copy%describe(other_grid, mesh_name=name)
  call check(all(other_grid%first == grid%first) .and. all(other_grid%size == grid%size) .and. name == 'sphere3', 'description')
  call copy%slab(slab)
  call check(all(slab%bricks() == bricks) .and. all(slab%inside() == inside), 'bricks of a field')
  call check(all(slab%part%first == whole%first), 'layers of a field')
  call slab%array(CLSDF_DISTANCE, values)
  call slab%array(CLSDF_TRIANGLE, triangles)
  call slab%array(CLSDF_GRADIENT, directions)
  call slab%array(CLSDF_CLOSEST, doubles)
  call check(all(values == phi) .and. all(triangles == triangle), 'values of a field')
  call check(all(directions == gradient .or. spread(triangle == 0, 1, 3)), 'gradients of a field')
  call check(all(shape(doubles) == shape(gradient)), 'closest points of a field')
  call slab%array(CLSDF_DISTANCE, doubles, stat, errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'give a pointer to such an array, (i, j, k, brick)')
  call slab%find(bricks(:, 7) + 7, number)
  call check(number == 7, 'the brick of a sample')
  call slab%find(whole%first, number)
  call check(number == 0, 'a sample without a brick')
  allocate (samples(3, size(expected)), distances(size(expected)))
  at = 0
  do k = 0, whole%size(3) - 1
    do j = 0, whole%size(2) - 1
      do i = 0, whole%size(1) - 1
        at = at + 1
        samples(:, at) = whole%first + [i, j, k]
      end do
    end do
  end do
  call slab%distances(band, samples, distances)
  call check(all(distances == reshape(expected, [size(expected)])), 'distances of samples')
  call slab%distances(band, samples(:2, :), distances, stat, errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'give them (3, n) and (n)')

  ! Many in one call.
  requests(1)%grid = whole
  requests(1)%grid%size(3) = 16
  requests(2)%grid = whole
  requests(2)%grid%first(3) = whole%first(3) + 16
  requests(2)%grid%size(3) = whole%size(3) - 16
  requests%band = band
  requests(2)%outputs = [CLSDF_TRIANGLE]
  call transform%compute_sparse_field(requests, fields)
  call fields(1)%slab(slab)
  number = slab%brick_count
  call check(all(slab%bricks() == bricks(:, :number)), 'bricks of the first part')
  call fields(2)%slab(slab)
  call check(number + slab%brick_count == counts%bricks, 'bricks of the second part')
  call slab%array(CLSDF_TRIANGLE, triangles)
  call check(all(triangles == triangle(:, :, :, number + 1:)), 'triangles of the second part')
  requests(2)%grid%size(1) = 0
  call transform%compute_sparse_field(requests, fields, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'request 1 of 2')
  call check(.not. any(fields%is_set()), 'fields after an error')

contains

  pure function dense(sample) result(value)
    integer(8), intent(in) :: sample(3)
    real(4) :: value
    integer(8) :: a(3)
    a = sample - whole%first + 1
    value = expected(a(1), a(2), a(3))
  end function

  pure function number_at(sample) result(value)
    integer(8), intent(in) :: sample(3)
    integer :: value
    integer(8) :: a(3)
    a = sample - whole%first + 1
    value = numbers(a(1), a(2), a(3))
  end function

  pure function vector_at(sample) result(value)
    integer(8), intent(in) :: sample(3)
    real(4) :: value(3)
    integer(8) :: a(3)
    a = sample - whole%first + 1
    value = vectors(:, a(1), a(2), a(3))
  end function

end program
