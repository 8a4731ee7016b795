# clsdf_documented_code(<page> <blocks> <label> <source>...): the code of a page, which is a part of programs that are tested.
function(clsdf_documented_code page blocks label)
  list(TRANSFORM ARGN PREPEND ${PROJECT_SOURCE_DIR}/)
  add_test(
    NAME code_of_${page}
    COMMAND ${CMAKE_COMMAND} -DPAGE=${PROJECT_SOURCE_DIR}/docs/${page}.md "-DSOURCES=${ARGN}" -DBLOCKS=${blocks}
            -DRUNS_PYTHON=$<STREQUAL:${page},scenes> -P ${PROJECT_SOURCE_DIR}/tests/documents/documented_code.cmake)
  set_tests_properties(code_of_${page} PROPERTIES LABELS ${label})
endfunction()

clsdf_documented_code(parallel 11 examples examples/mesh_on_ranks.cpp)
clsdf_documented_code(scenes 5 examples examples/links_of_an_arm.cpp examples/rotor_and_stator.cpp)  # and programs in Python
clsdf_documented_code(petsc 4 integrations integrations/petsc/examples/dmda.cpp integrations/petsc/examples/dmda.c
                      integrations/petsc/examples/dmda.F90 integrations/petsc/tests/dmda_test.cpp)
clsdf_documented_code(flow 2 integrations integrations/peclet/flow_past_a_body.py integrations/lbmpy/drag_of_a_body.py)
clsdf_documented_code(dealii 3 integrations integrations/dealii/examples/forest.cpp integrations/dealii/tests/forest_test.cpp)
clsdf_documented_code(amrex 7 integrations tests/documents/amrex_classes.hpp tests/documents/amrex.cpp
                      tests/documents/amrex_cuda.cpp)
clsdf_documented_code(cuda 4 examples examples/field_for_cuda.cpp bindings/c/examples/field_for_cuda.c)

# AMReX is not installed: a stand-in for its classes.
add_executable(test_code_for_amrex ${CMAKE_CURRENT_LIST_DIR}/amrex.cpp)
target_include_directories(test_code_for_amrex PRIVATE ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(test_code_for_amrex PRIVATE clsdf::meshes clsdf::clsdf clsdf_warnings)
add_test(NAME code_for_amrex COMMAND test_code_for_amrex)
set_tests_properties(code_for_amrex PROPERTIES LABELS integrations)

# The same in memory of CUDA.
add_executable(test_code_for_amrex_cuda ${CMAKE_CURRENT_LIST_DIR}/amrex_cuda.cpp)
target_include_directories(test_code_for_amrex_cuda PRIVATE ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(test_code_for_amrex_cuda PRIVATE clsdf::cuda clsdf::meshes clsdf::clsdf clsdf_cuda_stand_in clsdf_warnings)
add_test(NAME code_for_amrex_cuda COMMAND test_code_for_amrex_cuda)
set_tests_properties(code_for_amrex_cuda PROPERTIES LABELS "cuda;integrations")

# The pages of the site: every link between documents leads somewhere, every page is in a table of contents, and the lines of
# the first screen stand in tested documents.
if(EXISTS /usr/bin/python3)
  add_test(NAME site_pages COMMAND /usr/bin/python3 ${PROJECT_SOURCE_DIR}/packaging/site/pages.py ${PROJECT_SOURCE_DIR}
                                   ${CMAKE_CURRENT_BINARY_DIR}/site-pages)
else()
  add_test(NAME site_pages COMMAND ${CMAKE_COMMAND} -E echo "skipped: /usr/bin/python3 is not installed")
  set_tests_properties(site_pages PROPERTIES SKIP_REGULAR_EXPRESSION "^skipped")
endif()
set_tests_properties(site_pages PROPERTIES LABELS build)
