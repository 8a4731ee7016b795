# The installed package, for find_package(clsdf) and for pkg-config.
include(CMakePackageConfigHelpers)

set(package_directory ${CMAKE_INSTALL_LIBDIR}/cmake/clsdf)
set(targets clsdf)
if(CLSDF_BUILD_REFERENCE)
  list(APPEND targets clsdf_reference)
  set_target_properties(clsdf_reference PROPERTIES EXPORT_NAME reference)
endif()
if(CLSDF_BUILD_PICTURE)
  list(APPEND targets clsdf_picture)
endif()
install(TARGETS ${targets} EXPORT clsdfTargets FILE_SET HEADERS)
if(CLSDF_BUILD_APPS)
  install(TARGETS clsdf_command)
endif()
install(EXPORT clsdfTargets NAMESPACE clsdf:: DESTINATION ${package_directory})

# A static library does not carry what it stands on, so whoever links it has to find that.
get_target_property(library_type clsdf TYPE)
set(CLSDF_CONFIG_DEPENDENCIES "find_dependency(Eigen3)")
set(CLSDF_PC_REQUIRES "eigen3")
set(CLSDF_PC_LIBRARIES "")
set(CLSDF_PC_LIBRARIES_PRIVATE "")
if(library_type STREQUAL "STATIC_LIBRARY")
  foreach(package OpenCL TBB fmt)
    string(APPEND CLSDF_CONFIG_DEPENDENCIES "\nfind_dependency(${package})")
  endforeach()
  string(APPEND CLSDF_PC_REQUIRES " OpenCL tbb fmt mpfr gmp expat")
  # HDF5's own description has another name on every system.
  set(CLSDF_PC_LIBRARIES "-l${CLSDF_HDF5_NAME}")
  if(CLSDF_WITH_OPENVDB)
    string(APPEND CLSDF_PC_LIBRARIES " -lopenvdb -lImath")
  endif()
  # What a C++ compiler links by itself and a C compiler, as the linker of a mixed program, does not.
  set(libraries ${CMAKE_CXX_IMPLICIT_LINK_LIBRARIES})
  list(REMOVE_ITEM libraries gcc gcc_s c)
  list(REMOVE_DUPLICATES libraries)
  list(TRANSFORM libraries PREPEND -l)
  list(JOIN libraries " " CLSDF_PC_LIBRARIES_PRIVATE)
endif()
# Relative to the file itself, so that the installed tree can be moved.
file(RELATIVE_PATH CLSDF_PC_INCLUDEDIR ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_FULL_INCLUDEDIR})

configure_package_config_file(cmake/clsdfConfig.cmake.in ${PROJECT_BINARY_DIR}/clsdfConfig.cmake
                              INSTALL_DESTINATION ${package_directory} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/clsdfConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/clsdfConfig.cmake ${PROJECT_BINARY_DIR}/clsdfConfigVersion.cmake
        DESTINATION ${package_directory})

configure_file(cmake/clsdf.pc.in ${PROJECT_BINARY_DIR}/clsdf.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/clsdf.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
