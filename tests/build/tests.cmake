# Promises that the build itself makes.

# The embedding does not change texts with characters that are special in CMake's lists and C++'s literals.
set(treacherous ${CMAKE_CURRENT_BINARY_DIR}/treacherous.cl)
string(REPEAT "${CMAKE_CURRENT_LIST_DIR}/treacherous.txt;" 256 copies)
execute_process(COMMAND ${CMAKE_COMMAND} -E cat ${copies} OUTPUT_FILE ${treacherous} COMMAND_ERROR_IS_FATAL ANY)
clsdf_test(embedding LABELS build launch)
clsdf_embed_kernels(test_embedding ${treacherous} ${CMAKE_CURRENT_LIST_DIR}/empty.h)
target_compile_definitions(test_embedding PRIVATE TREACHEROUS="${treacherous}")

# Nothing of the library proper is compiled with a header of CGAL that is under the GPL.
add_test(
  NAME licences
  COMMAND ${CMAKE_COMMAND} -DBUILD=${PROJECT_BINARY_DIR} -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/licences
          -P ${CMAKE_CURRENT_LIST_DIR}/licences.cmake)

# Sections that comments cite by their titles are there.
add_test(NAME citations COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -P
                                ${CMAKE_CURRENT_LIST_DIR}/citations.cmake)

# The folders of the core are layers.
add_test(NAME layers COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_LIST_DIR}/layers.cmake)

# Each folder has tests with the label that docs/architecture.md names.
add_test(NAME labels COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -DBUILD=${PROJECT_BINARY_DIR} -DCTEST=${CMAKE_CTEST_COMMAND}
                             -DAPPS=${CLSDF_BUILD_APPS} -P ${CMAKE_CURRENT_LIST_DIR}/labels.cmake)

# Instruction sets are named in one kernel file.
add_test(NAME simd COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_LIST_DIR}/simd.cmake)

# Files that use fmt::join include fmt/ranges.h, which fmt 11 needs.
add_test(NAME joins COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_LIST_DIR}/joins.cmake)

# One file of the command includes CLI11, and one nlohmann's JSON.
add_test(NAME slow_headers COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -P ${CMAKE_CURRENT_LIST_DIR}/slow_headers.cmake)

# A compiler in C++17 mode prints one message with the remedy.
get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
add_test(
  NAME needs_cxx20
  COMMAND ${CMAKE_COMMAND} -DHEADERS=${PROJECT_SOURCE_DIR}/lib/include -DEIGEN=${eigen} -DCOMPILER=${CMAKE_CXX_COMPILER}
          -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/needs_cxx20 -P ${CMAKE_CURRENT_LIST_DIR}/needs_cxx20.cmake)

# The build with default options.
clsdf_turn(2 turn)
add_test(NAME users_build ${turn} COMMAND ${CMAKE_COMMAND} -DCLSDF=${PROJECT_SOURCE_DIR} -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/users_build
                                  -P ${CMAKE_CURRENT_LIST_DIR}/users_build.cmake)
add_test(NAME setup COMMAND ${CMAKE_COMMAND} -DCLSDF=${PROJECT_SOURCE_DIR} -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/setup -P
                            ${CMAKE_CURRENT_LIST_DIR}/setup.cmake)
add_test(NAME scripts COMMAND ${CMAKE_COMMAND} -DCLSDF=${PROJECT_SOURCE_DIR} -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/scripts -P
                              ${CMAKE_CURRENT_LIST_DIR}/scripts.cmake)
add_test(NAME release COMMAND ${CMAKE_COMMAND} -DCLSDF=${PROJECT_SOURCE_DIR} -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/release -P
                              ${CMAKE_CURRENT_LIST_DIR}/release.cmake)
set_tests_properties(licences citations layers labels simd joins slow_headers needs_cxx20 users_build setup scripts release PROPERTIES LABELS build)
set_tests_properties(release PROPERTIES SKIP_REGULAR_EXPRESSION "skipped: ")

# Enumerations and plain structs of the public headers have counterparts in C. The headers left out are Eigen's, and those
# of libraries that a C interface would not have; and that of scenes, which C++ alone has.
if(CLSDF_TEST_PYTHON)
  if(Git_FOUND)
    add_test(NAME held COMMAND ${CLSDF_TEST_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/held.py ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_BINARY_DIR}/held)
    set_tests_properties(held PROPERTIES LABELS build)
  endif()
  add_test(NAME c_names COMMAND ${CLSDF_TEST_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/c_names.py ${PROJECT_SOURCE_DIR}/lib/include/clsdf
                                ${CMAKE_CURRENT_BINARY_DIR}/c_names.c cc eigen.hpp openvdb.hpp row_tables.hpp scene.hpp)
  set_tests_properties(c_names PROPERTIES LABELS bindings)
endif()
