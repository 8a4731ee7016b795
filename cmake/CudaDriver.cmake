# CLSDF_CUDA_DRIVER: what programs that include cuda.h link, CUDA's driver or the tests' stand-in for it; empty if there is
# neither. clsdf itself links neither: it opens the driver at run time.
set(CLSDF_CUDA_DRIVER "")
if(TARGET clsdf_cuda_stand_in)
  set(CLSDF_CUDA_DRIVER clsdf_cuda_stand_in)
else()
  find_package(CUDAToolkit QUIET)
  if(TARGET CUDA::cuda_driver)
    set(CLSDF_CUDA_DRIVER CUDA::cuda_driver)
  endif()
endif()
