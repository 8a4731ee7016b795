# Readers of files, fed with damaged ones. With CLSDF_FUZZ (clang) by libFuzzer, for as long as one likes:
#   fuzz_readers --format=off --seeds=FOLDER -max_total_time=60 FOLDER
# and else by replay.cpp. The tests are a sample: what corpus/ keeps, sound files cut short, some thousand damaged ones.
add_executable(fuzz_readers ${CMAKE_CURRENT_LIST_DIR}/one_input.cpp ${CMAKE_CURRENT_LIST_DIR}/readers.cpp)
target_compile_definitions(fuzz_readers PRIVATE CLSDF_FUZZ_CORPUS="${CMAKE_CURRENT_LIST_DIR}/corpus"
                                                CLSDF_WITH_OPENVDB=$<BOOL:${CLSDF_WITH_OPENVDB}>)
target_include_directories(fuzz_readers PRIVATE ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(fuzz_readers PRIVATE ${CLSDF_TESTED} clsdf_warnings)
if(CLSDF_FUZZ)
  target_link_options(fuzz_readers PRIVATE -fsanitize=fuzzer)
else()
  target_sources(fuzz_readers PRIVATE ${CMAKE_CURRENT_LIST_DIR}/replay.cpp)
endif()

set(formats off obj stl ply points_csv points_npy points_ply nrrd nrrd_triangle npy npy_json vti h5 sdf)
if(CLSDF_WITH_OPENVDB)
  list(APPEND formats vdb)
endif()
foreach(format ${formats})
  if(CLSDF_FUZZ)
    set(seeds ${CMAKE_CURRENT_BINARY_DIR}/fuzz/${format})
    add_test(NAME fuzz_${format} COMMAND fuzz_readers --format=${format} --seeds=${seeds} -runs=20000 -seed=1 -max_len=8192
                                         -timeout=20 -malloc_limit_mb=256 -rss_limit_mb=1024 -detect_leaks=0
                                         ${seeds})
  else()
    add_test(NAME fuzz_${format} COMMAND fuzz_readers --format=${format} --runs=3000)
  endif()
  set_tests_properties(fuzz_${format} PROPERTIES LABELS io)
endforeach()
if(CLSDF_SANITIZE)
  # As in tests/io/tests.cmake: HDF5's leaks with damaged files.
  set_tests_properties(fuzz_h5 PROPERTIES ENVIRONMENT_MODIFICATION
                       "ASAN_OPTIONS=string_append::fast_unwind_on_malloc=0:malloc_context_size=12")
endif()
