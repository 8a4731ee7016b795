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

add_custom_target(accept COMMAND ${PROJECT_SOURCE_DIR}/scripts/accept VERBATIM USES_TERMINAL)
