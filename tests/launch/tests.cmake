# The programs as a GPU's compiler gets them, for the test below and for scripts/gpu-compile.
add_executable(write_programs ${CMAKE_CURRENT_LIST_DIR}/write_programs.cpp)
target_link_libraries(write_programs PRIVATE clsdf::clsdf clsdf::papers clsdf_papers_internals clsdf_internals clsdf_warnings Eigen3::Eigen OpenCL::OpenCL
                                             TBB::tbb ${CLSDF_FMT})
if(CLSDF_BUILD_PICTURE)
  target_compile_definitions(write_programs PRIVATE CLSDF_TEST_PICTURE)
  target_link_libraries(write_programs PRIVATE clsdf::picture clsdf_picture_internals)
endif()

# A compiler that inlines nothing finds every function that a kernel calls.
find_program(CLSDF_CLANG NAMES clang clang-21 clang-20 clang-19 clang-18 clang-17 clang-16 clang-15 clang-14)
mark_as_advanced(CLSDF_CLANG)
add_test(NAME without_inlining
         COMMAND ${CMAKE_COMMAND} -DCLANG=${CLSDF_CLANG} -DWRITE_PROGRAMS=$<TARGET_FILE:write_programs>
                 -DFOLDER=${CMAKE_CURRENT_BINARY_DIR}/programs -P ${CMAKE_CURRENT_LIST_DIR}/without_inlining.cmake)
set_tests_properties(without_inlining PROPERTIES LABELS launch SKIP_REGULAR_EXPRESSION "skipped: clang is not installed")

# CLSDF_SORT_BITS: with -C nightly 2^24 keys.
clsdf_test(radix_sort LABELS launch LINK clsdf::reference OpenCL::OpenCL AS_GPU)
add_test(NAME radix_sort_long COMMAND test_radix_sort --color_output=no --run_test=many_keys_are_sorted CONFIGURATIONS nightly)
set_tests_properties(radix_sort_long PROPERTIES ENVIRONMENT CLSDF_SORT_BITS=24 LABELS "launch;nightly" TIMEOUT 3600)

clsdf_field_test(short_launches LABELS launch lists sign)
