!> What the examples share.
module example
  use, intrinsic :: iso_c_binding
  implicit none
contains

  !> For tests alone: appends the bytes of a packed array, at c_loc(array), to the file that the environment variable
  !> CLSDF_EXAMPLE_ARRAYS names, if it is set, so that the same example in another language can be compared with this one.
  subroutine record(first, bytes)
    type(c_ptr), intent(in) :: first
    integer, intent(in) :: bytes
    integer(c_int8_t), pointer :: values(:)
    character(4096) :: path
    integer :: unit, status
    call get_environment_variable('CLSDF_EXAMPLE_ARRAYS', path, status=status)
    if (status /= 0) return
    call c_f_pointer(first, values, [bytes])
    open (newunit=unit, file=trim(path), access='stream', form='unformatted', position='append', action='write')
    write (unit) values
    close (unit)
  end subroutine

  !> Argument n of the program as a number.
  function argument(n, otherwise) result(number)
    integer, intent(in) :: n, otherwise
    integer :: number
    character(32) :: text
    number = otherwise
    if (command_argument_count() < n) return
    call get_command_argument(n, text)
    read (text, *) number
  end function

end module
