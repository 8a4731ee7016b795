! Arrays of any kind, rank, bounds and strides are used where they are: addresses are compared, and what a section leaves out
! stays.
program arrays
  use, intrinsic :: iso_c_binding
  use clsdf
  use test
  implicit none
  integer, parameter :: n = 12
  type(clsdf_device) :: device
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: grid
  type(clsdf_band) :: band
  real(8), target :: x(3, 4)
  integer, target :: triangles(3, 4)
  real(4) :: expected(n, n, n), vectors(3, n, n, n)
  integer :: numbers(n, n, n)

  call device%automatic()
  call tetrahedron(x, triangles)
  call transform%create(device, x, triangles)
  grid = clsdf_grid(-0.15d0, 0.12d0, [n, n, n])
  band = clsdf_band_symmetric(0.3d0)
  call transform%compute(grid, band, expected, triangle=numbers, gradient=vectors)
  call check(minval(expected) < -0.05 .and. maxval(expected) > 0.1, 'distances on both sides')
  call addresses()
  call sections()
  call bounds()
  call kinds()
  call vectors_of_both_orders()
  call indices()
  call blocks()
  call points()
  call shapes()

contains

  integer(c_intptr_t) function address(pointer)
    type(c_ptr), intent(in) :: pointer
    address = transfer(pointer, address)
  end function

  ! The first element and the strides that a call sees of a section, against the addresses of its elements.
  subroutine addresses()
    real(8), target :: u(0:9, -3:7, 5, 2)
    real(8), pointer :: section(:, :, :)
    type(clsdf_array) :: array
    integer(c_int64_t) :: begin
    section => u(1:9:2, 7:-3:-5, :, 2)
    array = clsdf_array(section)
    begin = address(c_loc(u(1, 7, 1, 2)))
    call check(address(array%host) == begin, 'the first element of a section is used where it is')
    call check(all(array%shape(1:3) == [5, 3, 5]) .and. array%rank == 3, 'its shape')
    call check(array%strides(1) == address(c_loc(u(3, 7, 1, 2))) - begin, 'its stride along the first axis')
    call check(array%strides(2) == address(c_loc(u(1, 2, 1, 2))) - begin .and. array%strides(2) < 0, 'a negative stride')
    call check(array%strides(3) == address(c_loc(u(1, 7, 2, 2))) - begin, 'its stride along the third axis')
    ! Handed on through a call, as the procedures do.
    call through(u(1:9:2, 7:-3:-5, :, 2), begin)
    array = clsdf_array(u(:, :, :, 1))
    call check(address(array%host) == address(c_loc(u(0, -3, 1, 1))), 'lower bounds do not count')
  end subroutine

  subroutine through(section, begin)
    real(8), intent(inout), target :: section(:, :, :)
    integer(c_int64_t), intent(in) :: begin
    type(clsdf_array) :: array
    array = clsdf_array(section)
    call check(address(array%host) == begin .and. array%strides(1) == 16, 'a section is handed on without a copy')
  end subroutine

  subroutine sections()
    real(4) :: u(0:2*n, -1:n + 1, 2, n + 2)
    logical :: left_out(0:2*n, -1:n + 1, 2, n + 2)
    u = 7
    left_out = .true.
    left_out(1::2, n:1:-1, 2, 2:n + 1) = .false.
    call transform%compute(grid, band, u(1::2, n:1:-1, 2, 2:n + 1))
    call check(all(u(1::2, 1:n, 2, 2:n + 1) == expected(:, n:1:-1, :)), 'a section with strides, backwards')
    call check(all(pack(u, left_out) == 7), 'what a section leaves out stays')
    call check(count(left_out) == size(u) - n**3, 'and is the rest')
  end subroutine

  subroutine bounds()
    real(4) :: phi(-2:n - 3, 5:n + 4, n)
    type(clsdf_grid) :: shifted
    phi = 7
    ! The grid has the bounds of the array: phi(i, j, k) lies at origin + ((i, j, k) - 1) * spacing.
    shifted = clsdf_grid(-0.15d0, 0.12d0, shape(phi), lbound(phi))
    shifted%origin = grid%origin - 0.12d0*([-2, 5, 1] - 1)
    call transform%compute(shifted, band, phi)
    call check(maxval(abs(phi - expected)) < 1e-6, 'lower bounds are those of the grid')
    call check(all(abs(shifted%position(-2, 5, 1) - grid%position(1, 1, 1)) < 1d-12), 'a position')
    call check(all(shifted%last() == ubound(phi)), 'upper bounds')
  end subroutine

  subroutine kinds()
    real(8) :: phi(n, n, n), gradient(3, n, n, n), closest(3, n, n, n), barycentric(2, n, n, n), offset(3, n, n, n)
    real(4) :: offset_of_4(3, n, n, n)
    real(4), target :: single(n, n, n)
    real(8), target :: points_of_surface(3, n, n, n)
    integer(c_int8_t), target :: site(n, n, n)
    call transform%compute(grid, band, phi, site=site, gradient=gradient, closest=closest, barycentric=barycentric, &
        offset=offset)
    call check(maxval(abs(phi - expected)) < 1d-6, 'doubles')
    call check(all(abs(gradient - vectors) < 1e-6 .or. vectors /= vectors), 'gradients of both kinds')
    call check(all(site >= -1 .and. site <= 6) .and. any(site == 6) .and. any(site == -1) .and. any(site == 3), 'sites')
    call check(all((site == -1) .eqv. (numbers == 0)), 'no site and no triangle beyond the band')
    call check(maxval(abs(sum(gradient**2, 1) - 1), site >= 0) < 1d-6, 'unit vectors')
    call check(all(abs(sqrt(sum(offset**2, 1)) - abs(phi)) < 1d-12 .or. site == -1), 'the offset is as long as the distance')
    call transform%compute(grid, band, single, offset=offset_of_4)
    call check(all(real(offset, 4) == offset_of_4 .or. spread(site == -1, 1, 3)), 'offsets of both kinds')
    call check(minval(barycentric, spread(site, 1, 2) >= 0) >= 0, 'weights')
    ! Of several kinds in one call.
    call transform%compute(grid, band, [clsdf_target(CLSDF_DISTANCE, single), clsdf_target(CLSDF_CLOSEST, points_of_surface)])
    call check(all(single == expected), 'a distance of real(4)')
    call check(all(points_of_surface == closest .or. spread(site == -1, 1, 3)), 'and a closest point of real(8)')
  end subroutine

  subroutine vectors_of_both_orders()
    real(4) :: last(n, n, n, 3), larger(n, n, 0:n, 5), phi(n, n, n)
    call transform%compute(grid, band, phi, gradient=last)
    call check(all(last(:, :, :, 2) == vectors(2, :, :, :) .or. numbers == 0), 'components after the samples')
    larger = 7
    call transform%compute(grid, band, phi, gradient=larger(:, :, 1:, 2:4))
    call check(all(larger(:, :, 1:, 4) == vectors(3, :, :, :) .or. numbers == 0), 'components in a section')
    call check(all(larger(:, :, 0, :) == 7) .and. all(larger(:, :, :, 1) == 7) .and. all(larger(:, :, :, 5) == 7), &
        'and nothing else')
  end subroutine

  subroutine indices()
    integer :: at(3), other(n, n, n)
    type(clsdf_mesh) :: mesh
    type(clsdf_transform) :: same
    integer, allocatable :: own(:, :)
    real(8), pointer :: vertices(:, :)
    real(4) :: phi(n, n, n)
    call check(minval(numbers) == 0 .and. maxval(numbers) == 4, 'triangles count from 1, and are 0 beyond the band')
    ! Beside the face x + y + z = 1, the fourth triangle.
    at = nint(([0.45d0, 0.45d0, 0.45d0] - grid%origin)/grid%spacing) + 1
    call check(numbers(at(1), at(2), at(3)) == 4, 'the fourth triangle')
    call mesh%create(real(x, 4), int(triangles, 8), 'tetrahedron')
    call mesh%triangles(own)
    call mesh%vertices(vertices)
    call check(all(own == triangles) .and. all(vertices == x), 'a mesh has the arrays that it was made of')
    call check(mesh%name() == 'tetrahedron', 'its name')
    call check(mesh%index_base() == 1, 'base 1')
    call same%create(device, mesh)
    call same%compute(grid, band, phi, triangle=other)
    call check(all(other == numbers) .and. all(phi == expected), 'from real(4) and integer(8)')
    call mesh%create(transpose(x), transpose(triangles))
    call mesh%triangles(own)
    call check(all(own == triangles), 'indices of a transposed array')
    call mesh%set_index_base(0)
    call same%create(device, mesh)
    call same%compute(grid, band, phi, triangle=other)
    call check(all(other == numbers - 1), 'base 0')
    call check(same%index_base() == 0, 'base 0 of a transform')
  end subroutine

  subroutine blocks()
    integer, parameter :: first(3, 2) = reshape([1, 1, 1, 5, 3, 7], [3, 2])
    real(4) :: phi(4, 5, 6, 2), gradient(3, 4, 5, 6, 2), last(4, 5, 6, 3, 0:2)
    integer :: triangle(4, 5, 6, 2)
    type(clsdf_request) :: requests(2)
    real(4), target :: a(4, 5, 6)
    real(8), target :: b(2, n, 3)
    call transform%compute_blocks(grid, band, first, phi, triangle=triangle, gradient=gradient)
    call check(all(phi(:, :, :, 1) == expected(1:4, 1:5, 1:6)), 'the first block')
    call check(all(phi(:, :, :, 2) == expected(5:8, 3:7, 7:12)), 'the second block')
    call check(all(triangle(:, :, :, 2) == numbers(5:8, 3:7, 7:12)), 'its triangles')
    call check(all(gradient(:, :, :, :, 2) == vectors(:, 5:8, 3:7, 7:12) .or. &
        spread(triangle(:, :, :, 2) == 0, 1, 3)), 'its gradients')
    last = 7
    call transform%compute_blocks(grid, band, first, phi, gradient=last(:, :, :, :, 1:))
    call check(all(last(:, :, :, 1, 2) == gradient(1, :, :, :, 2) .or. triangle(:, :, :, 2) == 0), 'components before blocks')
    call check(all(last(:, :, :, :, 0) == 7), 'and nothing else')

    requests(1)%grid = grid%part([1, 1, 1], [4, 5, 6])
    requests(1)%band = band
    requests(1)%targets = [clsdf_target(CLSDF_DISTANCE, a)]
    requests(2)%grid = grid%block([3, 1, 2], [2, n, 3])
    requests(2)%band = band
    requests(2)%targets = [clsdf_target(CLSDF_DISTANCE, b)]
    call transform%compute(requests)
    call check(all(a == expected(1:4, 1:5, 1:6)) .and. maxval(abs(b - expected(3:4, :, 2:4))) < 1d-6, 'requests of both kinds')
  end subroutine

  subroutine points()
    real(8) :: p(3, n**3), q(n**3, 3), d(n**3), e(n**3), sparse(2*n**3), normal(n**3, 3)
    real(8), allocatable :: xs(:), ys(:), zs(:)
    integer :: triangle(n**3), i, j, k, m
    real(4) :: single(n**3)
    m = 0
    do k = 1, n
      do j = 1, n
        do i = 1, n
          m = m + 1
          p(:, m) = grid%position(i, j, k)
        end do
      end do
    end do
    call transform%query(p, 0.3d0, d, triangle=triangle)
    call check(maxval(abs(d - reshape(expected, [n**3]))) < 1d-6, 'points are samples')
    call check(count(triangle /= reshape(numbers, [n**3])) < 40, 'their triangles, ties apart')
    q = transpose(p)
    call transform%query(q, 0.3d0, e, gradient=normal)
    call check(all(e == d), 'points(n, 3)')
    call check(all(abs(sum(normal**2, 2) - 1) < 1d-6 .or. triangle == 0), 'gradient(n, 3)')
    call transform%query(q(:, 1), q(:, 2), q(:, 3), 0.3d0, e)
    call check(all(e == d), 'columns')
    xs = q(:, 1)
    ys = q(:, 2)
    allocate (zs(n**3 + 17))
    zs(18:) = q(:, 3)
    sparse = 7
    call transform%query(xs, ys, zs(18:), 0.3d0, sparse(::2))
    call check(all(sparse(::2) == d) .and. all(sparse(2::2) == 7), 'three arrays')
    call transform%query(real(p, 4), 0.3d0, single)
    call check(maxval(abs(single - d)) < 1e-6, 'points of real(4)')
    call transform%query(p(:, 1:0), 0.3d0, d(1:0))
    call transform%query(p(:, 1:1), 0.3d0, e(1:1))
    call check(e(1) == d(1), 'one point')
    call transform%query(q(1:3, :), 0.3d0, e(1:3))  ! three points in (3, 3): the columns
    call check(abs(e(1) - d(1)) > 0 .or. abs(e(2) - d(2)) > 0, 'of two readings, components come first')
  end subroutine

  subroutine shapes()
    real(4) :: phi(n, n + 1, n), gradient(4, n, n, n)
    integer :: stat
    character(200) :: errmsg
    call transform%compute(grid, band, phi, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'distance has the shape (12, 13, 12); give it (12, 12, 12)')
    call transform%compute(grid, band, phi(:, :n, :), gradient=gradient, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'give it (3, 12, 12, 12) or (12, 12, 12, 3)')
  end subroutine

end program
