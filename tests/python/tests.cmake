# The Python package, built on this library and installed, passes its own tests (bindings/python/tests). A sanitized library is
# not one to install. scripts/test takes the packages that it needs, and compiles it, while other targets are compiled; else the
# test does.
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
  set(libraries clsdf clsdf_meshes clsdf_io)
  if(CLSDF_BUILD_CUDA)
    list(APPEND libraries clsdf_cuda)
  endif()
  list(TRANSFORM libraries REPLACE "(.+)" "$<TARGET_FILE:\\1>")
  add_custom_command(
    OUTPUT ${package}
    COMMAND ${script} --build ${PROJECT_BINARY_DIR}
    COMMAND ${CMAKE_COMMAND} -E touch ${package}
    DEPENDS ${environment} ${sources} ${headers} ${libraries}
    COMMENT "Building the Python package"
    VERBATIM)
  add_custom_target(python_package DEPENDS ${package})
  add_test(NAME python COMMAND sh -c "'${CMAKE_COMMAND}' --build '${PROJECT_BINARY_DIR}' --target python_package && exec '${script}' --run '${PROJECT_BINARY_DIR}'")
  # The longest one: it begins first, beside others.
  set_tests_properties(python PROPERTIES LABELS bindings SKIP_REGULAR_EXPRESSION "(^|\n)skipped: " COST 2000
                                          TIMEOUT 1800)
endif()
