clsdf_field_test(self_test known_field.cpp LABELS checks)
target_link_libraries(test_checks_self_test PRIVATE clsdf::papers clsdf_papers_internals)
# Kernels that are made wrong on purpose are compiled anew.
set_tests_properties(checks_self_test PROPERTIES TIMEOUT 900)
add_test(NAME checks_every_mutation
         COMMAND test_checks_self_test --color_output=no
                 --run_test=the_self_test/refuses_wrong_kernels_before_the_first_result
         CONFIGURATIONS nightly)
set_tests_properties(checks_every_mutation PROPERTIES ENVIRONMENT CLSDF_EVERY_MUTATION=1 LABELS "checks;nightly" TIMEOUT 3600)
