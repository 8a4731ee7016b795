# The list of fields by which the program is accepted. The test runs a part of it on meshes made by code; the target
# `accept` all of it, which takes three quarters of an hour and fetches meshes.
clsdf_require(CLI11 libcli11-dev CONFIG)
add_executable(acceptance)
foreach(source main case shape_cases strained_cases random_cases archive_cases run calls cost record)
  target_sources(acceptance PRIVATE ${CMAKE_CURRENT_LIST_DIR}/${source}.cpp)
endforeach()
target_include_directories(acceptance PRIVATE ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(acceptance PRIVATE clsdf::io clsdf::reference clsdf_internals Eigen3::Eigen CLI11::CLI11 ${CLSDF_FMT}
                                         clsdf_warnings)
add_test(NAME acceptance COMMAND acceptance --sampled)
set_tests_properties(acceptance PROPERTIES LABELS accuracy)

# With -C nightly the whole list, with both bodies of the kernels, in parts of about 50 fields. It fetches the meshes.
set(parts 24)
math(EXPR last "${parts} - 1")
add_test(NAME acceptance_meshes COMMAND ${PROJECT_SOURCE_DIR}/scripts/fetch-meshes CONFIGURATIONS nightly)
set_tests_properties(acceptance_meshes PROPERTIES LABELS accuracy FIXTURES_SETUP acceptance_meshes)
foreach(part RANGE ${last})
  add_test(NAME acceptance_part_${part}
           COMMAND acceptance --complete --body both --meshes ${PROJECT_SOURCE_DIR}/build/meshes --parts ${parts} --part ${part}
           CONFIGURATIONS nightly)
  set_tests_properties(acceptance_part_${part} PROPERTIES LABELS accuracy FIXTURES_REQUIRED acceptance_meshes TIMEOUT 3600)
endforeach()

add_custom_target(accept COMMAND ${PROJECT_SOURCE_DIR}/scripts/accept VERBATIM USES_TERMINAL)
