! Buffers of the device: plans, and calls that write to a buffer, against the same field on the host.
module opencl
  use, intrinsic :: iso_c_binding
  implicit none
  interface
    function create_buffer(context, flags, bytes, host, status) bind(C, name="clCreateBuffer") result(buffer)
      import
      type(c_ptr), value :: context, host
      integer(c_int64_t), value :: flags
      integer(c_size_t), value :: bytes
      integer(c_int), intent(out) :: status
      type(c_ptr) :: buffer
    end function
    function read_buffer(queue, buffer, blocking, offset, bytes, host, count, wait_list, event) &
        bind(C, name="clEnqueueReadBuffer") result(status)
      import
      type(c_ptr), value :: queue, buffer, host, wait_list, event
      integer(c_int), value :: blocking, count
      integer(c_size_t), value :: offset, bytes
      integer(c_int) :: status
    end function
    function release_event(event) bind(C, name="clReleaseEvent") result(status)
      import
      type(c_ptr), value :: event
      integer(c_int) :: status
    end function
    function release_buffer(buffer) bind(C, name="clReleaseMemObject") result(status)
      import
      type(c_ptr), value :: buffer
      integer(c_int) :: status
    end function
  end interface
end module

program plans
  use, intrinsic :: iso_c_binding
  use clsdf
  use opencl
  use test
  implicit none
  type(clsdf_device) :: device
  type(clsdf_mesh) :: mesh
  type(clsdf_transform) :: transform
  type(clsdf_grid) :: grid, part
  type(clsdf_band) :: band, own_band
  type(clsdf_plan) :: plan, copy
  type(clsdf_point_plan) :: point_plan
  type(clsdf_request) :: requests(2)
  type(clsdf_block_set) :: blocks
  type(clsdf_statistics) :: statistics
  type(c_ptr) :: context, id, queue, buffer, done(1)
  real(4), allocatable, target :: expected(:, :, :), found(:, :, :), moved(:, :, :)
  integer(c_int) :: status
  integer :: n
  integer :: stat
  character(300) :: errmsg

  call device%automatic()
  call device%handles(context, id, queue)
  call mesh%shape('torus')
  call transform%create(device, mesh)
  band = clsdf_band_symmetric(0.2d0)
  call grid%around(mesh, 32, band)
  allocate (expected(grid%size(1), grid%size(2), grid%size(3)))
  allocate (found, moved, mold=expected)
  n = size(expected)
  call transform%compute(grid, band, expected)
  buffer = create_buffer(context, 1_8, int(4*n, c_size_t), c_null_ptr, status)
  call check(status == 0, 'a buffer')

  ! Without a plan.
  call transform%compute(grid, band, [clsdf_target(CLSDF_DISTANCE, buffer, CLSDF_FLOAT32)])
  call fetch()
  call check(all(found == expected), 'a field in a buffer')

  ! One grid, into the targets of each run.
  call plan%create(transform, grid, band)
  copy = plan
  call plan%enqueue_to([clsdf_target(CLSDF_DISTANCE, buffer, CLSDF_FLOAT32)], queue, done=done(1))
  call fetch(done)
  call check(all(found == expected), 'a plan')
  status = release_event(done(1))
  call check(copy%request_count() == 1, 'requests of a plan')
  call copy%request(1, part, own_band)
  call check(all(part%first == grid%first) .and. all(part%size == grid%size), 'a request of a plan')
  call check(plan%sign() == transform%sign(), 'its sign')
  statistics = plan%statistics()
  call check(statistics%device_bytes > 0, 'its statistics')

  ! Requests with targets of their own: the two halves, each with the strides of the whole.
  call halves()
  call check(plan%bytes(transform, requests) > 0, 'the memory of a plan')
  call plan%create(transform, requests)
  call plan%enqueue()
  call fetch()
  call check(all(found == expected), 'a plan of requests')
  call transform%set_motion(reshape([0d0, 1d0, 0d0, -1d0, 0d0, 0d0, 0d0, 0d0, 1d0], [3, 3]), [0.1d0, 0d0, 0d0])
  call transform%compute(grid, band, moved)
  call check(any(moved /= expected), 'a motion')
  call plan%update(transform)
  call plan%enqueue(queue)
  call fetch()
  call check(all(found == moved), 'a plan after a motion')
  call plan%update(transform, requests%grid)
  call plan%update(transform, requests(2:))
  call check(plan%request_count() == 1, 'other requests')

  ! Blocks: slices.
  blocks%lattice = grid
  blocks%band = band
  blocks%size = [grid%size(1), grid%size(2), 1_8]
  allocate (blocks%first(3, grid%size(3)))
  blocks%first(1:2, :) = 1
  blocks%first(3, :) = [(n, n=1, size(expected, 3))]
  n = size(expected)
  blocks%targets = [clsdf_target(CLSDF_DISTANCE, buffer, CLSDF_FLOAT32)]
  call check(plan%bytes(transform, blocks) > 0, 'the memory of a plan of blocks')
  call plan%create(transform, blocks)
  call plan%update(transform, blocks)
  call plan%enqueue(queue)
  call fetch()
  call check(all(found == moved), 'a plan of blocks')

  call sparse_fields()

  ! In memory of the device triangles count from 0.
  call transform%compute(grid, band, [clsdf_target(CLSDF_DISTANCE, buffer, CLSDF_FLOAT32), &
      clsdf_target(CLSDF_TRIANGLE, buffer, CLSDF_UINT32)], stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_UNSUPPORTED, errmsg, 'index base')
  call point_plans()
  call link_plans()
  call plan%release()
  call copy%release()
  call plan%enqueue(stat=stat, errmsg=errmsg)
  call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'plan is null')
  status = release_buffer(buffer)

contains

  !> A sparse field that stays on the device has the bytes of one on the host.
  subroutine sparse_fields()
    type(clsdf_sparse_plan) :: plan, copy
    type(clsdf_sparse_request) :: request
    type(clsdf_sparse_counts) :: room, own_room
    type(clsdf_device_sparse_counts), target :: counts
    type(clsdf_sparse_buffers) :: buffers
    type(clsdf_sparse_field) :: field
    type(clsdf_sparse_slab) :: slab
    integer(c_int64_t), allocatable, target :: bricks(:, :)
    real(4), allocatable, target :: values(:, :, :, :)
    real(4), pointer :: on_host(:, :, :, :)
    type(c_ptr) :: end_of_run
    integer :: step
    request%grid = grid
    request%band = clsdf_band_symmetric(2*grid%spacing(1))
    room%bricks = 1
    call plan%create(transform, request, room)
    copy = plan
    do step = 1, 3
      if (step == 3) then
        call transform%set_motion(reshape([0d0, 1d0, 0d0, -1d0, 0d0, 0d0, 0d0, 0d0, 1d0], [3, 3]), [0d0, 0.1d0, 0d0])
        call plan%update(transform)
      end if
      buffers%counts = create_buffer(context, 1_8, c_sizeof(counts), c_null_ptr, status)
      buffers%bricks = create_buffer(context, 1_8, int(24*room%bricks, c_size_t), c_null_ptr, status)
      buffers%inside = create_buffer(context, 1_8, int(32*room%runs + 32, c_size_t), c_null_ptr, status)
      buffers%values = [clsdf_target(CLSDF_DISTANCE, &
          create_buffer(context, 1_8, int(2048*room%bricks, c_size_t), c_null_ptr, status), CLSDF_FLOAT32)]
      call plan%enqueue(buffers, queue, done=end_of_run)
      status = release_event(end_of_run)
      status = read_buffer(queue, buffers%counts, 1, 0_c_size_t, c_sizeof(counts), c_loc(counts), 0, c_null_ptr, &
          c_null_ptr)
      if (step == 1) then
        call check(counts%is_complete == 0 .and. counts%bricks > 1, 'too little room')
        room%bricks = counts%bricks + 100
        room%runs = counts%runs + 100
        call plan%update(transform, request, room)
        cycle
      end if
      call transform%compute_sparse_field(request%grid, request%band, field)
      call field%slab(slab)
      call check(counts%is_complete == 1 .and. counts%bricks == slab%brick_count, 'the counts of a run')
      call check(counts%runs == slab%run_count, 'the runs of a run')
      allocate (bricks(3, counts%bricks), values(8, 8, 8, counts%bricks))
      status = read_buffer(queue, buffers%bricks, 1, 0_c_size_t, int(24*counts%bricks, c_size_t), c_loc(bricks), 0, &
          c_null_ptr, c_null_ptr)
      status = read_buffer(queue, buffers%values(1)%array%device, 1, 0_c_size_t, int(2048*counts%bricks, c_size_t), &
          c_loc(values), 0, c_null_ptr, c_null_ptr)
      call slab%array(CLSDF_DISTANCE, on_host)
      call check(all(bricks + 1 == slab%bricks()), 'the bricks of a run')
      call check(all(values == on_host), 'the values of a run')
      deallocate (bricks, values)
    end do
    call copy%request(part, own_band, own_room)
    call check(all(part%size == grid%size) .and. own_room%bricks == room%bricks, 'the request of a sparse plan')
    call check(plan%sign() == transform%sign(), 'the sign of a sparse plan')
    statistics = plan%statistics()
    call check(statistics%device_bytes > 0, 'the statistics of a sparse plan')
    buffers%bricks = c_null_ptr
    call plan%enqueue(buffers, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'array of bricks has no memory')
    call plan%release()
    call plan%enqueue(buffers, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'sparse plan is null')
  end subroutine

  !> Points and results in one buffer, one after the other.
  subroutine point_plans()
    integer(8), parameter :: count = 200
    real(8), target :: points(3, count), back(3, count), with_room(4*count)
    real(4), target :: distances(count)
    real(4), target :: in_buffer(count)
    integer(1), target :: outcome(count)
    type(c_ptr), target :: event(1)
    type(c_ptr) :: memory
    integer(8) :: i
    points = reshape([(0.01d0*mod(i*37, 101_8) - 0.5d0, i=1, 3*count)], [3_8, count])
    with_room(:3*count) = reshape(points, [3*count])
    with_room(3*count + 1:) = 0
    call transform%query(clsdf_array(points), 0.3d0, [clsdf_target(CLSDF_DISTANCE, distances)])
    memory = create_buffer(context, ior(1_8, 32_8), int(30*count, c_size_t), c_loc(with_room), status)
    call check(status == 0, 'a buffer of points')
    call point_plan%create(transform, count, 0.3d0)
    call check(point_plan%is_set() .and. point_plan%count() == count, 'a plan of points')
    call check(point_plan%sign() == transform%sign(), 'its sign')
    statistics = point_plan%statistics()
    call check(statistics%device_bytes > 0, 'its statistics')
    call point_plan%update(transform)
    call point_plan%enqueue(clsdf_array(memory, CLSDF_FLOAT64, count=count), &
        [clsdf_target(CLSDF_DISTANCE, memory, CLSDF_FLOAT32, offset=24*count)], &
        clsdf_array(memory, CLSDF_UINT8, count=count, offset=28*count), queue, done=event(1))
    status = read_buffer(queue, memory, 1, int(0, c_size_t), int(24*count, c_size_t), c_loc(back), 1, c_loc(event), &
        c_null_ptr)
    status = read_buffer(queue, memory, 1, int(24*count, c_size_t), int(4*count, c_size_t), c_loc(in_buffer), 0, &
        c_null_ptr, c_null_ptr)
    status = read_buffer(queue, memory, 1, int(28*count, c_size_t), int(count, c_size_t), c_loc(outcome), 0, &
        c_null_ptr, c_null_ptr)
    call check(all(back == points), 'the points stay')
    call check(all(in_buffer == distances), 'distances of a plan of points')
    call check(all(outcome == CLSDF_FOUND), 'the outcome of points')
    status = release_event(event(1))
    call point_plan%enqueue(clsdf_array(memory, CLSDF_FLOAT64, count=count + 1), &
        [clsdf_target(CLSDF_DISTANCE, memory, CLSDF_FLOAT32)], stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'at most 200 points')
    call point_plan%release()
    status = release_buffer(memory)
  end subroutine

  !> Links in one buffer: the count, the parts, and the sides of the samples.
  subroutine link_plans()
    integer(4), allocatable :: directions(:, :)
    type(clsdf_links) :: links
    type(clsdf_link_plan) :: link_plan
    type(clsdf_link_buffers) :: buffers
    type(clsdf_device_link_count), target :: total
    type(clsdf_grid) :: of_plan
    real(8), allocatable, target :: q(:)
    integer(1), allocatable, target :: inside(:)
    type(c_ptr) :: memory
    integer(8) :: count, samples, room
    samples = product(grid%size)
    call clsdf_stencil('D3Q19', 'OpenLB', directions)
    call transform%links(grid, directions, links)
    count = size(links%q, kind=8)
    call link_plan%create(transform, grid, directions, count)
    call check(link_plan%is_set() .and. link_plan%sign() == transform%sign(), 'a plan of links')
    statistics = link_plan%statistics()
    call check(statistics%device_bytes > 30*count, 'its statistics')
    call link_plan%grid(of_plan, room)
    call check(room == count .and. all(of_plan%size == grid%size) .and. all(of_plan%first == grid%first), 'its grid')
    call link_plan%update(transform)
    memory = create_buffer(context, 1_8, int(16 + 8*count + samples, c_size_t), c_null_ptr, status)
    buffers%room = count
    buffers%count = memory
    buffers%q = clsdf_array(memory, CLSDF_FLOAT64, offset=16_8)
    buffers%inside = clsdf_array(memory, CLSDF_UINT8, count=samples, offset=16 + 8*count)
    call link_plan%enqueue(buffers, queue)
    allocate (q(count), inside(samples))
    status = read_buffer(queue, memory, 1, 0_c_size_t, 16_c_size_t, c_loc(total), 0, c_null_ptr, c_null_ptr)
    status = read_buffer(queue, memory, 1, 16_c_size_t, int(8*count, c_size_t), c_loc(q), 0, c_null_ptr, c_null_ptr)
    status = read_buffer(queue, memory, 1, int(16 + 8*count, c_size_t), int(samples, c_size_t), c_loc(inside), 0, &
        c_null_ptr, c_null_ptr)
    call check(total%links == count .and. total%is_complete == 1 .and. all(q == links%q), 'links of a plan')
    call check(all(inside == reshape(links%inside, [samples])), 'sides of a plan')
    call link_plan%update(transform, grid%part([1_8, 1_8, 1_8], [4_8, 4_8, 4_8]), 3_8)
    call link_plan%enqueue(buffers, queue, stat=stat, errmsg=errmsg)
    call fails(stat, CLSDF_INVALID_ARGUMENT, errmsg, 'inside.count is')
    call link_plan%release()
    status = release_buffer(memory)
  end subroutine

  subroutine halves()
    integer(8) :: first(3), half(3), bytes
    half = grid%size
    half(3) = grid%size(3)/2
    first = [1_8, 1_8, half(3) + 1]
    requests(1)%grid = grid%part([1_8, 1_8, 1_8], half)
    requests(2)%grid = grid%part(first, [half(1), half(2), grid%size(3) - half(3)])
    requests%band = band
    bytes = 4*product(half)
    requests(1)%targets = [clsdf_target(CLSDF_DISTANCE, buffer, CLSDF_FLOAT32)]
    requests(2)%targets = [clsdf_target(CLSDF_DISTANCE, buffer, CLSDF_FLOAT32, offset=bytes)]
  end subroutine

  ! The buffer, after the events.
  subroutine fetch(events)
    type(c_ptr), intent(in), target, optional :: events(:)
    type(c_ptr) :: first
    integer(c_int) :: count
    first = c_null_ptr
    count = 0
    if (present(events)) then
      first = c_loc(events(1))
      count = size(events)
    end if
    found = 7
    status = read_buffer(queue, buffer, 1, 0_c_size_t, int(4*n, c_size_t), c_loc(found), count, first, c_null_ptr)
    call check(status == 0, 'a buffer is read')
  end subroutine

end program
