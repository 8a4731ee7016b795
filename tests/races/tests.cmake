# The kernels on a simulated device that watches every access to memory, if oclgrind is installed.
find_program(CLSDF_OCLGRIND oclgrind)
mark_as_advanced(CLSDF_OCLGRIND)
if(CLSDF_OCLGRIND AND NOT CLSDF_SANITIZE)
  clsdf_test_program(races races.cpp)
  target_link_libraries(test_races PRIVATE clsdf::papers clsdf::reference OpenCL::OpenCL)
  clsdf_take_turns(
    races COMMAND ${CLSDF_OCLGRIND} --data-races --check-api $<TARGET_FILE:test_races>
    CASES a_band*:every_sample*:counted*:boxes*:methods* a_mesh_that*:many*:links_of*:keys*:a_topology*:groups*
          points*:completed*:links_and*:cut*
    LABELS launch frusta tree lists sign finish bricks targets points papers)
  set_tests_properties(races_0 races_1 races_2 PROPERTIES FAIL_REGULAR_EXPRESSION "data race;Invalid;Error;OCLGRIND"
                                                          PASS_REGULAR_EXPRESSION "No errors detected"
                                                          ENVIRONMENT_MODIFICATION "CLSDF_CACHE_DIR=set:;CLSDF_SELF_TEST=set:0")
endif()
