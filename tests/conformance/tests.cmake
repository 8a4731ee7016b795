# The conformance set (conformance/README.md): it is made anew, compared with its digest, computed by a second program, and
# asked of the library. Python without NumPy skips what the judge is needed for.
if(CLSDF_TEST_PYTHON)
  set(conformance_set ${CMAKE_CURRENT_BINARY_DIR}/conformance)
  add_test(NAME conformance_set COMMAND ${CLSDF_TEST_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/make_set.py
                                        ${PROJECT_SOURCE_DIR}/conformance ${conformance_set})
  set_tests_properties(conformance_set PROPERTIES FIXTURES_SETUP conformance LABELS "conformance;tools")

  clsdf_test(conformance_answers answers.cpp LABELS conformance reference LINK nlohmann_json::nlohmann_json)
  # Contracted products would be others.
  target_compile_options(test_conformance_answers PRIVATE -ffp-contract=off)
  clsdf_test(conformance_distances distances.cpp LABELS conformance points accuracy LINK nlohmann_json::nlohmann_json OpenCL::OpenCL)
  foreach(test answers distances)
    target_compile_definitions(
      test_conformance_${test} PRIVATE CLSDF_CONFORMANCE_SET="${conformance_set}" CLSDF_TEST_PYTHON="${CLSDF_TEST_PYTHON}"
                                       CLSDF_JUDGE="${PROJECT_SOURCE_DIR}/conformance/judge.py")
    # Not called test_*: they need the set, and are not bundled.
    set_target_properties(test_conformance_${test} PROPERTIES OUTPUT_NAME conformance_${test})
    set_tests_properties(conformance_${test} PROPERTIES FIXTURES_REQUIRED conformance)
  endforeach()

  add_test(NAME conformance_judge COMMAND ${CLSDF_TEST_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/seeded_faults.py
                                          ${PROJECT_SOURCE_DIR}/conformance ${conformance_set}
                                          $<$<TARGET_EXISTS:clsdf_command>:$<TARGET_FILE:clsdf_command>>)
  set_tests_properties(conformance_judge PROPERTIES FIXTURES_REQUIRED conformance LABELS "conformance;command"
                                                    SKIP_REGULAR_EXPRESSION "skipped: ")
endif()
