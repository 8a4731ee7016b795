! Many bodies: tetrahedra with poses, held against their own transforms.
program scenes
  use, intrinsic :: iso_c_binding
  use clsdf
  use test
  implicit none
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh, outer
  type(clsdf_outer_report) :: report
  integer(c_int32_t), allocatable :: bodies_of_outer(:)
  type(clsdf_scene) :: scene, other, of_union
  type(clsdf_transform) :: transform
  type(clsdf_pose) :: poses(3), pose
  type(clsdf_kept_memory) :: memory
  type(clsdf_box) :: boxes(2)
  integer, parameter :: n = 200
  real(8) :: x(3, 4), points(3, n), distance(n), expected(n), of_body(n), of_bodies(n, 3), closest(3, n), offset(3, n), &
      winding(n), of_pairs(3), matrix(4, 4), turn(3, 3)
  real(4) :: single(3, n), distance_4(n), offset_4(3, n)
  integer :: triangles(3, 4), i, stat
  integer(c_int32_t) :: bodies(n), triangle(n), pairs(2, 3)
  integer(c_int8_t) :: own(n), inside(n), places(2)
  integer(8) :: body
  type(clsdf_grid) :: grid
  type(clsdf_band) :: band
  type(clsdf_field) :: field
  real(4), allocatable, target :: least(:, :, :), of_one(:, :, :), expected_field(:, :, :)
  integer(c_int32_t), allocatable, target :: numbers(:, :, :)
  integer(c_int32_t), pointer :: of_field(:, :, :)
  character(400) :: errmsg
  real(8), parameter :: no_limit = huge(1d0)

  call device%automatic()
  call tetrahedron(x, triangles)
  call mesh%create(x, triangles)
  call scene%create(device)
  call scene%query(points, no_limit, distance, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'has no bodies')
  call scene%add(mesh, body)
  call check(body == 1, 'the first body')
  call scene%add_instance(1_8, body)
  call check(body == 2, 'an instance')
  call scene%outer(outer, report=report)
  call outer%given_bodies(bodies_of_outer)
  call check(size(bodies_of_outer) == 4 .and. all(bodies_of_outer == 1), 'the outer surface of two equal bodies')
  call check(report%volume > 0 .and. report%hidden_faces == 4, 'its report')
  pose%translation = [9d0, 0d0, 0d0]
  call scene%add(mesh, body, pose=pose, sign=CLSDF_SIGN_NONE)
  call check(body == 3 .and. scene%size() == 3 .and. scene%has_sign(), 'three bodies')
  call check(scene%sign(1_8) == CLSDF_SIGN_NONZERO .and. scene%sign(3_8) == CLSDF_SIGN_NONE, 'the rules')
  call scene%outer(outer, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'body 2')
  memory = scene%memory()
  call check(memory%host_bytes >= 0, 'the memory')

  ! Rotations as reals of 4 bytes have them.
  do i = 1, 3
    turn = reshape([cos(1d0*i), sin(1d0*i), 0d0, -sin(1d0*i), cos(1d0*i), 0d0, 0d0, 0d0, 1d0], [3, 3])
    poses(i)%rotation = real(real(turn, 4), 8)
    poses(i)%translation = [0.2d0*i, 0.1d0*i, 0d0]
  end do
  call scene%set_poses(poses)
  do i = 1, n
    points(:, i) = [modulo(0.377d0*i, 2d0) - 0.8d0, modulo(0.713d0*i, 2d0) - 0.8d0, modulo(0.531d0*i, 1.4d0) - 0.4d0]
  end do

  ! Two equal bodies hide nothing of each other.
  call transform%create(device, mesh)
  call transform%query(points, no_limit, expected)
  call of_union%create(device, surface=CLSDF_SURFACE_OUTER)
  call of_union%add(mesh)
  call of_union%add_instance(1_8)
  call of_union%query(points, no_limit, distance)
  call check(all(abs(distance - expected) < 1d-12), 'the union of two equal bodies')
  call of_union%add(mesh, sign=CLSDF_SIGN_NONE, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'outer surface')

  expected = no_limit
  do i = 1, 3
    pose = scene%pose(int(i, 8))
    call check(maxval(abs(matmul(pose%rotation, transpose(pose%rotation)) - &
        reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3]))) < 1d-15, 'a rotation')
    call check(maxval(abs(pose%rotation - poses(i)%rotation)) < 1d-6, 'the nearest rotation')
    call transform%create(device, mesh, sign=scene%sign(int(i, 8)))
    call transform%set_motion(pose%rotation, pose%translation)
    call transform%query(points, no_limit, of_body)
    of_bodies(:, i) = of_body
    expected = min(expected, of_body)
  end do
  call scene%query(points, no_limit, distance, triangle=triangle, closest=closest, offset=offset, body=bodies, own=own)
  call check(maxval(abs(distance - expected)) < 1d-13, 'the least distance')
  do i = 1, n
    call check(abs(of_bodies(i, bodies(i)) - expected(i)) < 1d-13, 'the nearest body')
  end do
  call check(all(triangle >= 1 .and. triangle <= 4), 'triangles')
  call check(maxval(abs(points + offset - closest)) < 1d-13, 'offsets')
  call check(all(own == 1 .or. distance <= 0) .and. any(own == 0) .and. any(distance < 0), 'own distances')
  single = real(points, 4)
  call scene%query(single, no_limit, distance_4, offset=offset_4)
  call check(maxval(abs(distance_4 - expected)) < 1d-6, 'reals of 4 bytes')
  call scene%query(points, 0.1d0, distance, body=bodies)
  call check(all((bodies == 0) .eqv. (abs(expected) > 0.1d0)), 'no body beyond the half width')
  ! A field: each body's own field, moved there, has its values.
  boxes(1) = scene%box()
  call check(all(boxes(1)%lower > -2) .and. all(boxes(1)%upper < 2), 'the box of the scene')
  grid%origin = -2
  grid%spacing = 0.25d0
  grid%size = [17, 17, 17]
  allocate (least(17, 17, 17), of_one(17, 17, 17), numbers(17, 17, 17), expected_field(17, 17, 17))
  band = clsdf_band(inside=0.6d0, outside=0.6d0)
  expected_field = 0.6
  do i = 1, 3
    pose = scene%pose(int(i, 8))
    call transform%create(device, mesh, sign=scene%sign(int(i, 8)))
    call transform%set_motion(pose%rotation, pose%translation)
    call transform%compute(grid, band, of_one)
    expected_field = min(expected_field, of_one)
  end do
  call scene%compute(grid, band, [clsdf_target(CLSDF_DISTANCE, least), clsdf_target(CLSDF_BODY, numbers)])
  call check(all(least == expected_field) .and. any(least < 0), 'a field of bodies')
  call check(all((numbers >= 1 .and. numbers <= 3) .or. abs(least) >= 0.6) .and. any(numbers == 0), 'bodies of samples')
  call scene%compute_field(grid, band, field, [CLSDF_BODY])
  call field%array(CLSDF_BODY, of_field)
  call check(all(of_field == numbers), 'a field in the library''s memory')
  call scene%contains(points, inside)
  call scene%winding(points, winding)
  call check(all((inside == 1) .eqv. (expected < 0)) .and. any(inside == 1), 'points inside')
  call check(all(winding > 0.5d0 .or. inside == 0) .and. any(winding > 2.5d0), 'winding numbers')
  pairs = reshape([1, 1, 5, 3, n, 2], [2, 3])
  call scene%query_pairs(points, pairs, no_limit, of_pairs)
  call transform%query(points, no_limit, of_body)  ! the third body
  call check(abs(of_pairs(2) - of_body(5)) < 1d-13, 'pairs')
  boxes(1) = clsdf_box([5d0, 5d0, 5d0], [6d0, 6d0, 6d0])
  boxes(2) = clsdf_box([0d0, 0d0, 0d0], [1d0, 1d0, 1d0])
  call scene%classify(boxes, 0.1d0, places)
  call check(all(places == [CLSDF_OUTSIDE, CLSDF_WITHIN]), 'boxes')

  ! Some poses, a matrix, positions, bodies that are off; another handle of the same scene.
  matrix = reshape([0d0, 1d0, 0d0, 0d0, -1d0, 0d0, 0d0, 0d0, 0d0, 0d0, 1d0, 0d0, 2d0, 3d0, 4d0, 1d0], [4, 4])
  call pose%set_matrix(matrix)
  call check(all(pose%translation == [2, 3, 4]) .and. pose%rotation(1, 2) == -1, 'a matrix')
  other = scene
  call other%set_poses([2_8], [pose])
  pose = scene%pose(2_8)
  call check(all(pose%translation == [2, 3, 4]) .and. pose%rotation(2, 1) == 1, 'some poses')
  call scene%set_positions(1_8, 2*x)
  call scene%set_active(3_8, .false.)
  call check(.not. scene%is_active(3_8) .and. scene%is_active(2_8), 'a body that is off')

  ! What is wrong is named, and nothing changes.
  pose%rotation(1, 1) = 1
  call scene%set_poses([2_8], [pose], stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'body 1 is no rotation')
  call scene%set_poses(poses(1:2), stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, '2 poses and 3 bodies')
  call scene%set_poses([1_8, 2_8], poses(1:1), stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'shapes')
  call scene%set_poses([4_8], poses(1:1), stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'no body 4: the scene has 3, counted from 1')
  call scene%add(mesh, sign=CLSDF_SIGN_BELOW, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'below')
  call pose%set_matrix(transpose(matrix), stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'last row')
  call scene%query(points, no_limit, distance, body=bodies(2:), stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'body')
  pairs(2, 1) = 3
  call scene%query_pairs(points, pairs, no_limit, of_pairs, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'switched off')
  pairs(2, 1) = 0
  call scene%query_pairs(points, pairs, no_limit, of_pairs, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'count from 1')
  do i = 1, 3
    call scene%set_active(int(i, 8), .false.)
  end do
  call scene%contains(points, inside, stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'all 3 bodies')
  call check(scene%size() == 3 .and. scene%is_set(), 'three bodies again')
end program
