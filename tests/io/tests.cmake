# Files of meshes.
clsdf_test(mesh_file_formats mesh_file_formats.cpp face_groups.cpp other_writers.cpp mistaken_files.cpp polygons.cpp stl_files.cpp LABELS io)
clsdf_test(mesh_file_damage LABELS io)

# Files of fields.
clsdf_test(field round_trip.cpp nrrd.cpp npy.cpp damaged.cpp output.cpp writer.cpp other_programs.cpp hdf5_default_settings.cpp overlapping_amr.cpp part_files.cpp segment_files.cpp vdb.cpp
           LABELS io)
target_link_libraries(test_field PRIVATE clsdf_hdf5)

target_compile_definitions(test_field PRIVATE CLSDF_WITH_OPENVDB=$<BOOL:${CLSDF_WITH_OPENVDB}>)
if(CLSDF_SANITIZE)
  # By whole stacks cmake/leak_suppressions.txt knows what HDF5 forgets of damaged files; twelve callers tell.
  set_tests_properties(field PROPERTIES ENVIRONMENT_MODIFICATION
                       "ASAN_OPTIONS=string_append::fast_unwind_on_malloc=0:malloc_context_size=12")
endif()

if(NOT CLSDF_TEST_PARTS)
  clsdf_test(sparse_files sparse_files.cpp sparse_arrays.cpp LABELS io sparse LINK clsdf::reference)
  target_compile_definitions(test_sparse_files PRIVATE CLSDF_WITH_OPENVDB=$<BOOL:${CLSDF_WITH_OPENVDB}>)
  if(CLSDF_WITH_OPENVDB)
    clsdf_test(level_set LABELS io sparse LINK clsdf::reference clsdf_openvdb)
  endif()
endif()

# .nvdb files opened by NanoVDB, whose headers no other program includes.
find_path(CLSDF_NANOVDB_INCLUDE nanovdb/util/GridValidator.h)
mark_as_advanced(CLSDF_NANOVDB_INCLUDE)
clsdf_test(nvdb LABELS io)
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
clsdf_test(field_readers readers.cpp LABELS io)
set_target_properties(test_field_readers PROPERTIES OUTPUT_NAME field_readers)
target_compile_definitions(test_field_readers PRIVATE CLSDF_WITH_OPENVDB=$<BOOL:${CLSDF_WITH_OPENVDB}>
                                                      CLSDF_TEST_PYTHON="${CLSDF_TEST_PYTHON}"
                                                      CLSDF_READERS="${CMAKE_CURRENT_LIST_DIR}/readers.py")
