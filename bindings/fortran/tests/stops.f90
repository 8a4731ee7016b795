! Without stat, an error writes its message and stops the program.
program stops
  use clsdf
  implicit none
  type(clsdf_mesh) :: mesh
  character(100) :: errmsg
  call mesh%read('no such file.off', errmsg=errmsg)
  print '(a)', 'the program goes on'
end program
