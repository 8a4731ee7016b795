# A program of another project builds and runs against the library, in each of the ways there are to get at it.
# A sanitized library is not one to install.
if(NOT CLSDF_SANITIZE)
  set(fortran "")
  if(CLSDF_BUILD_FORTRAN)
    set(fortran fortran)
  endif()
  foreach(way documents find_package clang add_subdirectory components pkg_config c ${fortran} parallel_hdf5 shared)
    # These compile the library once more. scripts/try-debian, a step of .ci/run, does what add_subdirectory does.
    set(configurations "")
    if(way MATCHES "^(add_subdirectory|shared)$")
      set(configurations CONFIGURATIONS nightly)
    endif()
    add_test(
      NAME consumer_${way}
      COMMAND
        ${CMAKE_COMMAND} -DWAY=${way} -DCLSDF=${PROJECT_SOURCE_DIR} -DBUILD=${PROJECT_BINARY_DIR}
        -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/consumer/${way} -DGENERATOR=${CMAKE_GENERATOR}
        -DCOMPILER=${CMAKE_CXX_COMPILER} -DLAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER}
        -P ${CMAKE_CURRENT_LIST_DIR}/run.cmake ${configurations})
    set_tests_properties(consumer_${way} PROPERTIES LABELS build SKIP_REGULAR_EXPRESSION "skipped: ")
  endforeach()
  # ccache, if it is the launcher, keeps files with precompiled headers only if told so.
  set_tests_properties(consumer_add_subdirectory consumer_shared PROPERTIES LABELS "build;nightly" TIMEOUT 3600
                                                                            ENVIRONMENT CCACHE_SLOPPINESS=pch_defines,time_macros)
endif()
