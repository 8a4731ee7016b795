# clsdf_transform_test(<name> <source>...): fields held against the reference.
function(clsdf_transform_test name)
  clsdf_test(transform_${name} ${ARGN})
  target_link_libraries(test_transform_${name} PRIVATE clsdf::reference OpenCL::OpenCL)
endfunction()

foreach(name counterexamples shapes bands grids accuracy topology ties extremes determinism plans calls
             bodies slabs streams launches hostile_callers coarse_lists)
  clsdf_transform_test(${name} ${CMAKE_CURRENT_LIST_DIR}/${name}.cpp)
endforeach()

# As on processors with AVX2 and with SSE alone: Debian's PoCL compiles for the instruction set that is named. (One that
# is built for its own machine alone pays no heed.)
set(sets avx2 sse2)
set(widths 8 4)
foreach(set width IN ZIP_LISTS sets widths)
  foreach(test shapes accuracy)
    add_test(NAME transform_${test}_${set} COMMAND test_transform_${test} --color_output=no)
    set_tests_properties(transform_${test}_${set} PROPERTIES ENVIRONMENT
                         "POCL_KERNELLIB_NAME=${set};CLSDF_MAX_FLOAT_WIDTH=${width}")
  endforeach()
endforeach()
