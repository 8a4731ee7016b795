# The Python package, built on this library and installed, passes its own tests (bindings/python/tests). A sanitized library is
# not one to install. The packages that it needs are taken, and it is compiled, while other targets are.
if(NOT CLSDF_SANITIZE AND CLSDF_BUILD_IO AND CLSDF_BUILD_MESHES)
  set(script ${PROJECT_SOURCE_DIR}/scripts/python-tests)
  set(environment ${PROJECT_BINARY_DIR}/python/environment.stamp)
  set(package ${PROJECT_BINARY_DIR}/python/package.stamp)
  add_custom_command(
    OUTPUT ${environment}
    COMMAND ${script} --environment ${PROJECT_BINARY_DIR}
    COMMAND ${CMAKE_COMMAND} -E touch ${environment}
    DEPENDS ${script}
    COMMENT "Taking the packages that tests of Python need"
    VERBATIM)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/bindings/python/*)
  list(FILTER sources EXCLUDE REGEX "/(tests|build|__pycache__)/")
  file(GLOB headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/lib/include/clsdf/*)
  add_custom_command(
    OUTPUT ${package}
    COMMAND ${script} --build ${PROJECT_BINARY_DIR}
    COMMAND ${CMAKE_COMMAND} -E touch ${package}
    DEPENDS ${environment} ${sources} ${headers} $<TARGET_FILE:clsdf> $<TARGET_FILE:clsdf_meshes> $<TARGET_FILE:clsdf_io>
            $<TARGET_FILE:clsdf_cuda>
    COMMENT "Building the Python package"
    VERBATIM)
  add_custom_target(python_package ALL DEPENDS ${package})
  add_test(NAME python COMMAND ${script} --run ${PROJECT_BINARY_DIR})
  # The longest one: it begins first, beside others.
  set_tests_properties(python PROPERTIES LABELS bindings SKIP_REGULAR_EXPRESSION "^skipped: " COST 2000
                                          TIMEOUT 1800)
endif()
