# The kernels on a simulated device that watches every access to memory, if oclgrind is installed.
find_program(CLSDF_OCLGRIND oclgrind)
mark_as_advanced(CLSDF_OCLGRIND)
if(CLSDF_OCLGRIND AND NOT CLSDF_SANITIZE)
  clsdf_test_program(races races.cpp)
  target_link_libraries(test_races PRIVATE clsdf::papers clsdf::reference OpenCL::OpenCL)
  # The cases take turns: each build runs a third of them.
  set(cases a_band*:every_sample*:counted*:boxes*:methods* a_mesh_that*:many*:links_of*:keys*:a_topology*:groups* points*:completed*:links_and*:cut*)
  foreach(turn RANGE 2)
    clsdf_turn(${turn} configurations)
    list(GET cases ${turn} filter)
    add_test(NAME races_${turn} COMMAND ${CLSDF_OCLGRIND} --data-races --check-api $<TARGET_FILE:test_races> ${configurations})
    set_tests_properties(races_${turn} PROPERTIES FAIL_REGULAR_EXPRESSION "data race;Invalid;Error;OCLGRIND"
                                                  PASS_REGULAR_EXPRESSION "No errors detected" TIMEOUT 900
                                                  LABELS "launch;frusta;tree;lists;sign;finish;bricks;targets;points;papers"
                                                  ENVIRONMENT BOOST_TEST_RUN_FILTERS=${filter}
                                                  ENVIRONMENT_MODIFICATION "CLSDF_CACHE_DIR=set:;CLSDF_SELF_TEST=set:0")
  endforeach()
endif()
