clsdf_test(device ${CMAKE_CURRENT_LIST_DIR}/device.cpp ${CMAKE_CURRENT_LIST_DIR}/choice.cpp
           ${CMAKE_CURRENT_LIST_DIR}/errors.cpp ${CMAKE_CURRENT_LIST_DIR}/buffer_pool.cpp ${CMAKE_CURRENT_LIST_DIR}/records.cpp
           ${CMAKE_CURRENT_LIST_DIR}/prepared_programs.cpp
           ${CMAKE_CURRENT_LIST_DIR}/host_filling.cpp ${CMAKE_CURRENT_LIST_DIR}/known_faults.cpp)
target_link_libraries(test_device PRIVATE OpenCL::OpenCL)
# A process of its own: the loader looks for drivers once.
clsdf_test(no_device ${CMAKE_CURRENT_LIST_DIR}/no_device.cpp)
# Likewise: PoCL starts its threads once.
clsdf_test(floating_point ${CMAKE_CURRENT_LIST_DIR}/floating_point.cpp)
target_link_libraries(test_floating_point PRIVATE clsdf::reference)

add_executable(first_compute ${CMAKE_CURRENT_LIST_DIR}/first_compute.cpp)
target_link_libraries(first_compute PRIVATE clsdf::meshes clsdf::clsdf clsdf_warnings)
add_test(NAME first_compute COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:first_compute>
                                    -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/first_compute_files
                                    -P ${CMAKE_CURRENT_LIST_DIR}/first_compute.cmake)

# A program's own copy of OpenCL's binding and the library's do not mix. Only static libraries show the linker both.
get_target_property(clsdf_type clsdf TYPE)
if(clsdf_type STREQUAL STATIC_LIBRARY)
  add_executable(opencl_binding ${CMAKE_CURRENT_LIST_DIR}/opencl_binding.cpp)
  # An inlined function cannot be taken from elsewhere.
  target_compile_options(opencl_binding PRIVATE -O0)
  # Options stand before object files.
  target_link_options(opencl_binding PRIVATE LINKER:--whole-archive $<TARGET_FILE:clsdf> LINKER:--no-whole-archive)
  target_link_libraries(opencl_binding PRIVATE clsdf::clsdf OpenCL::OpenCL)
  add_test(NAME opencl_binding COMMAND opencl_binding)
  set(libraries $<TARGET_FILE:clsdf>)
  foreach(target clsdf_papers clsdf_picture)
    if(TARGET ${target})
      list(APPEND libraries $<TARGET_FILE:${target}>)
    endif()
  endforeach()
  list(JOIN libraries "," libraries)
  add_test(NAME opencl_binding_symbols COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DLIBRARIES=${libraries}
                                               -P ${CMAKE_CURRENT_LIST_DIR}/opencl_binding.cmake)
endif()
