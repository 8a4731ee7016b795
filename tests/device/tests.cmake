clsdf_test(device device.cpp choice.cpp errors.cpp buffer_pool.cpp records.cpp prepared_programs.cpp host_filling.cpp known_faults.cpp
           LABELS device LINK OpenCL::OpenCL AS_GPU)
# A process of its own: the loader looks for drivers once.
clsdf_test(no_device LABELS device)
# Likewise, of a bundled driver.
clsdf_test(broken_driver LABELS device)
# The driver that a package brings with it: a stand-in, and that of CLSDF_DRIVER_BUNDLE (scripts/bundle-driver).
set(CLSDF_DRIVER_BUNDLE "" CACHE PATH "A bundled driver to test, the folder that scripts/bundle-driver made")
mark_as_advanced(CLSDF_DRIVER_BUNDLE)
set(stand_in ${CMAKE_CURRENT_BINARY_DIR}/bundled_driver)
add_executable(write_bundle_stand_in ${CMAKE_CURRENT_LIST_DIR}/write_bundle_stand_in.cpp)
target_link_libraries(write_bundle_stand_in PRIVATE clsdf::meshes clsdf_internals OpenCL::OpenCL clsdf_warnings Eigen3::Eigen
                                                    TBB::tbb ${CLSDF_FMT})
target_include_directories(write_bundle_stand_in PRIVATE ${PROJECT_SOURCE_DIR}/tests)
add_test(NAME bundled_driver_written COMMAND write_bundle_stand_in ${stand_in})
clsdf_test(bundled_driver LABELS device LINK OpenCL::OpenCL)
set_tests_properties(bundled_driver_written PROPERTIES LABELS device FIXTURES_SETUP bundled_driver)
set_tests_properties(bundled_driver PROPERTIES FIXTURES_REQUIRED bundled_driver
                                               ENVIRONMENT "CLSDF_DRIVER=${stand_in};OCL_ICD_VENDORS=${stand_in}")
set_tests_properties(bundled_driver_written bundled_driver PROPERTIES ENVIRONMENT_MODIFICATION "POCL_KERNELLIB_NAME=unset:")
if(CLSDF_DRIVER_BUNDLE)
  set(environment "CLSDF_DRIVER=${CLSDF_DRIVER_BUNDLE};OCL_ICD_VENDORS=${CLSDF_DRIVER_BUNDLE}")
  add_test(NAME bundled_driver_of_package COMMAND test_bundled_driver --color_output=no)
  set_tests_properties(bundled_driver_of_package PROPERTIES LABELS device ENVIRONMENT "${environment}")
  if(TARGET clsdf_command)
    add_test(NAME bundled_programs COMMAND clsdf_command compile-ahead --device bundled --check)
    set_tests_properties(bundled_programs PROPERTIES LABELS device ENVIRONMENT "${environment}")
  endif()
endif()
# A process of its own: PoCL starts its threads once.
clsdf_test(floating_point LABELS device LINK clsdf::reference)

add_executable(first_compute ${CMAKE_CURRENT_LIST_DIR}/first_compute.cpp)
target_link_libraries(first_compute PRIVATE clsdf::meshes clsdf::clsdf clsdf_warnings)
add_test(NAME first_compute COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:first_compute>
                                    -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/first_compute_files
                                    -P ${CMAKE_CURRENT_LIST_DIR}/first_compute.cmake)
set_tests_properties(first_compute PROPERTIES LABELS "device;checks")

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
  set_tests_properties(opencl_binding opencl_binding_symbols PROPERTIES LABELS device)
endif()
