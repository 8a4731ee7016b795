# clsdf_transform_test(<name> <source>...): fields held against the reference.
function(clsdf_transform_test name)
  clsdf_test(transform_${name} ${ARGN})
  target_link_libraries(test_transform_${name} PRIVATE clsdf::reference OpenCL::OpenCL)
endfunction()

foreach(name counterexamples shapes bands grids accuracy double_distances topology sign_surface open_meshes ties extremes determinism plans calls
             outputs bodies slabs streams launches hostile_callers kernel_frusta plain_opencl
             slender_polyhedra self_test stages requests same_bytes points nearest_by_group classify restricted
             callers_memory point_plans shared_memory promises runs overlap blocks arrays sparse sparse_files sparse_plans)
  clsdf_transform_test(${name} ${CMAKE_CURRENT_LIST_DIR}/${name}.cpp)
endforeach()
foreach(name double_distances extremes outputs self_test promises sparse)
  target_link_libraries(test_transform_${name} PRIVATE clsdf::papers)
endforeach()
target_link_libraries(test_transform_self_test PRIVATE clsdf_papers_internals)
target_sources(test_transform_self_test PRIVATE ${PROJECT_SOURCE_DIR}/tests/checks/known_field.cpp)
target_sources(test_transform_points PRIVATE ${PROJECT_SOURCE_DIR}/tests/points/batches.cpp ${PROJECT_SOURCE_DIR}/tests/points/few_points.cpp
                                             ${PROJECT_SOURCE_DIR}/tests/points/unusable_points.cpp)
target_link_libraries(test_transform_determinism PRIVATE TBB::tbb)
# 10,000 steps of a moving body.
add_test(NAME transform_steps COMMAND test_transform_calls --color_output=no
                                      --run_test=steps_of_a_moving_body_leave_memory_as_it_was CONFIGURATIONS nightly)
set_tests_properties(transform_steps PROPERTIES ENVIRONMENT CLSDF_STEPS=10000 LABELS nightly TIMEOUT 3600)
# Kernels that are made wrong on purpose are compiled anew.
set_tests_properties(transform_self_test PROPERTIES TIMEOUT 900)

# As on processors with AVX2 and with SSE alone: Debian's PoCL compiles for the instructions that are named. (One that is
# built for its own machine alone pays no heed.)
set(names)
set(widths)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  list(APPEND names sse2)
  list(APPEND widths 4)
  if(EXISTS /proc/cpuinfo)
    file(READ /proc/cpuinfo processor)
    if(processor MATCHES "avx2")
      list(APPEND names avx2)
      list(APPEND widths 8)
    endif()
  endif()
endif()
foreach(instructions width IN ZIP_LISTS names widths)
  foreach(test shapes accuracy)
    add_test(NAME transform_${test}_${instructions} COMMAND test_transform_${test} --color_output=no)
    set_tests_properties(transform_${test}_${instructions} PROPERTIES ENVIRONMENT
                         "POCL_KERNELLIB_NAME=${instructions};CLSDF_MAX_FLOAT_WIDTH=${width}")
  endforeach()
  add_test(NAME transform_points_${instructions}
           COMMAND test_transform_points --color_output=no --run_test=many_points_give_the_bytes_of_few)
  set_tests_properties(transform_points_${instructions} PROPERTIES ENVIRONMENT
                       "POCL_KERNELLIB_NAME=${instructions};CLSDF_MAX_FLOAT_WIDTH=${width}")
endforeach()
