# clsdf_transform_test(<name> <source>...): fields held against the reference.
function(clsdf_transform_test name)
  clsdf_test(transform_${name} ${ARGN})
  target_link_libraries(test_transform_${name} PRIVATE clsdf::reference OpenCL::OpenCL)
endfunction()

foreach(name counterexamples shapes bands grids accuracy topology ties extremes determinism plans calls
             bodies slabs streams launches hostile_callers coarse_lists)
  clsdf_transform_test(${name} ${CMAKE_CURRENT_LIST_DIR}/${name}.cpp)
endforeach()
