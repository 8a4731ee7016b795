clsdf_field_test(self_test known_field.cpp LABELS checks)
target_link_libraries(test_checks_self_test PRIVATE clsdf::papers clsdf_papers_internals)
# Kernels that are made wrong on purpose are compiled anew.
set_tests_properties(checks_self_test PROPERTIES TIMEOUT 900)
# A third of them in each build; with -C nightly all, in ten parts.
set_tests_properties(checks_self_test PROPERTIES ENVIRONMENT CLSDF_MUTATIONS=${CLSDF_TURN}/3)
foreach(part RANGE 9)
  add_test(NAME checks_mutations_${part}
           COMMAND test_checks_self_test --color_output=no
                   --run_test=the_self_test/refuses_wrong_kernels_before_the_first_result
           CONFIGURATIONS nightly)
  set_tests_properties(checks_mutations_${part} PROPERTIES ENVIRONMENT CLSDF_MUTATIONS=${part}/10 LABELS "checks;nightly" TIMEOUT 3600)
endforeach()
