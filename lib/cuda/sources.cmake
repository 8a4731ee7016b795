# Memory of CUDA as inputs and outputs. The driver is opened at run time: nothing of CUDA is needed to build.
add_library(clsdf_cuda)
add_library(clsdf::cuda ALIAS clsdf_cuda)
set_target_properties(clsdf_cuda PROPERTIES EXPORT_NAME cuda)
target_sources(
  clsdf_cuda
  PRIVATE ${CMAKE_CURRENT_LIST_DIR}/arrays.cpp
          ${CMAKE_CURRENT_LIST_DIR}/driver.cpp
          ${CMAKE_CURRENT_LIST_DIR}/lanes.cpp
          ${CMAKE_CURRENT_LIST_DIR}/link.cpp
          ${CMAKE_CURRENT_LIST_DIR}/memory.cpp)
target_include_directories(clsdf_cuda PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_compile_options(clsdf_cuda PRIVATE -ffp-contract=off -fno-math-errno -fno-semantic-interposition)
target_link_libraries(
  clsdf_cuda
  PUBLIC clsdf::clsdf
  PRIVATE $<BUILD_INTERFACE:clsdf_internals> OpenCL::OpenCL ${CLSDF_FMT} ${CMAKE_DL_LIBS} $<BUILD_INTERFACE:clsdf_warnings>)
