# The Python package, built on this library and installed, passes its own tests (bindings/python/tests).
# A sanitized library is not one to install.
if(NOT CLSDF_SANITIZE AND CLSDF_BUILD_IO AND CLSDF_BUILD_MESHES)
  add_test(NAME python COMMAND ${PROJECT_SOURCE_DIR}/scripts/python-tests ${PROJECT_BINARY_DIR})
  # The longest one: it begins first, beside others.
  set_tests_properties(python PROPERTIES LABELS bindings SKIP_REGULAR_EXPRESSION "^skipped: " COST 2000
                                          TIMEOUT 1800)
endif()
