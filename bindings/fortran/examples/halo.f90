! The start of a finite difference code: a block of a larger domain, with a halo, as an array whose lower bounds are not 1.
! One call fills the block and its halo; another one fills the inner samples of one component of a larger array, and leaves
! all else as it is.
program halo
  use, intrinsic :: iso_c_binding
  use clsdf
  implicit none
  integer, parameter :: n = 48, ghosts = 3
  real(8), parameter :: h = 2.4d0/(n - 1), origin(3) = -1.2d0
  real(8) :: phi(1 - ghosts:n + ghosts, 1 - ghosts:n + ghosts, 1 - ghosts:n + ghosts)
  real(4) :: u(1 - ghosts:n + ghosts, 1 - ghosts:n + ghosts, 1 - ghosts:n + ghosts, 4)
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_band) :: band
  logical :: right

  call device%automatic()
  call mesh%shape('torus')
  call transform%create(device, mesh)
  band = clsdf_band_symmetric(4*h)

  ! phi(1, 1, 1) lies at the origin, and the halo around it: the grid takes the bounds of the array.
  call transform%compute(clsdf_grid(origin, h, shape(phi), lbound(phi)), band, phi)

  ! A section: component 2, without the halo.
  u = 7
  call transform%compute(clsdf_grid(origin, h, [n, n, n]), band, u(1:n, 1:n, 1:n, 2))

  right = maxval(abs(u(1:n, 1:n, 1:n, 2) - phi(1:n, 1:n, 1:n))) < 1d-6 .and. all(u(:, :, :, 1) == 7) .and. &
      all(u(:, :, :, 3:4) == 7) .and. all(u(:0, :, :, 2) == 7) .and. all(u(n + 1:, :, :, 2) == 7) .and. &
      all(u(:, :, :0, 2) == 7)
  print '(i0, a, i0, a)', count(phi(1:n, 1:n, 1:n) < 0), ' samples are inside, and ', &
      count(phi < 0) - count(phi(1:n, 1:n, 1:n) < 0), ' of the halo'
  if (.not. right .or. count(phi < 0) < 1000) error stop 'WRONG'
end program
