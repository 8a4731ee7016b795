clsdf_test(field ${CMAKE_CURRENT_LIST_DIR}/round_trip.cpp ${CMAKE_CURRENT_LIST_DIR}/nrrd.cpp
           ${CMAKE_CURRENT_LIST_DIR}/npy.cpp ${CMAKE_CURRENT_LIST_DIR}/damaged.cpp ${CMAKE_CURRENT_LIST_DIR}/output.cpp
           ${CMAKE_CURRENT_LIST_DIR}/writer.cpp ${CMAKE_CURRENT_LIST_DIR}/other_programs.cpp
           ${CMAKE_CURRENT_LIST_DIR}/hdf5_default_settings.cpp ${CMAKE_CURRENT_LIST_DIR}/vdb.cpp)
target_link_libraries(test_field PRIVATE clsdf_hdf5)

target_compile_definitions(test_field PRIVATE CLSDF_WITH_OPENVDB=$<BOOL:${CLSDF_WITH_OPENVDB}>)
if(CLSDF_SANITIZE)
  # By whole stacks cmake/leak_suppressions.txt knows what HDF5 forgets of damaged files; twelve callers tell.
  set_tests_properties(field PROPERTIES ENVIRONMENT_MODIFICATION
                       "ASAN_OPTIONS=string_append::fast_unwind_on_malloc=0:malloc_context_size=12")
endif()

if(NOT CLSDF_TEST_PARTS)
  clsdf_test(sparse_files ${CMAKE_CURRENT_LIST_DIR}/sparse_files.cpp ${CMAKE_CURRENT_LIST_DIR}/sparse_arrays.cpp)
  target_link_libraries(test_sparse_files PRIVATE clsdf::reference)
  target_compile_definitions(test_sparse_files PRIVATE CLSDF_WITH_OPENVDB=$<BOOL:${CLSDF_WITH_OPENVDB}>)
  if(CLSDF_WITH_OPENVDB)
    clsdf_test(level_set ${CMAKE_CURRENT_LIST_DIR}/level_set.cpp)
    target_link_libraries(test_level_set PRIVATE clsdf::reference clsdf_openvdb)
  endif()
endif()

# .nvdb files opened by NanoVDB, whose headers no other program includes.
find_path(CLSDF_NANOVDB_INCLUDE nanovdb/util/GridValidator.h)
mark_as_advanced(CLSDF_NANOVDB_INCLUDE)
clsdf_test(nvdb ${CMAKE_CURRENT_LIST_DIR}/nvdb.cpp)
target_compile_definitions(test_nvdb PRIVATE CLSDF_WITH_NANOVDB=$<BOOL:${CLSDF_NANOVDB_INCLUDE}>
                                             CLSDF_WITH_OPENVDB=$<BOOL:${CLSDF_WITH_OPENVDB}>)
if(CLSDF_NANOVDB_INCLUDE)
  target_include_directories(test_nvdb SYSTEM PRIVATE ${CLSDF_NANOVDB_INCLUDE})
endif()
set_tests_properties(nvdb PROPERTIES SKIP_REGULAR_EXPRESSION "skipped: NanoVDB is not installed")

# Fields opened by VTK, h5py, teem, numpy and OpenVDB. Not called test_*: it stays where these are, and is not bundled.
# Debian's modules are in the system's Python alone.
find_program(CLSDF_TEST_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
find_program(CLSDF_TEST_PYTHON python3)
mark_as_advanced(CLSDF_TEST_PYTHON)
clsdf_test(field_readers ${CMAKE_CURRENT_LIST_DIR}/readers.cpp)
set_target_properties(test_field_readers PROPERTIES OUTPUT_NAME field_readers)
target_compile_definitions(test_field_readers PRIVATE CLSDF_WITH_OPENVDB=$<BOOL:${CLSDF_WITH_OPENVDB}>
                                                      CLSDF_TEST_PYTHON="${CLSDF_TEST_PYTHON}"
                                                      CLSDF_READERS="${CMAKE_CURRENT_LIST_DIR}/readers.py")
