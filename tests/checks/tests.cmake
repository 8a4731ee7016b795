clsdf_field_test(self_test known_field.cpp LABELS checks)
target_link_libraries(test_checks_self_test PRIVATE clsdf::papers clsdf_papers_internals)
# Kernels that are made wrong on purpose are compiled anew.
set_tests_properties(checks_self_test PROPERTIES TIMEOUT 900)
