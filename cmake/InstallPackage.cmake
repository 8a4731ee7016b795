# The installed package, for find_package(clsdf) and for pkg-config. Each library is a component of its own (core, meshes,
# io, cuda, papers, picture, reference, c, c_io, fortran, fortran_io), and so is the command; headers, package files and what else a compiler needs are in
# development.
include(CMakePackageConfigHelpers)

set(package_directory ${CMAKE_INSTALL_LIBDIR}/cmake/clsdf)
get_target_property(library_type clsdf TYPE)
set(is_static FALSE)
if(library_type STREQUAL "STATIC_LIBRARY")
  set(is_static TRUE)
endif()
# Relative to the file itself, so that the installed tree can be moved.
file(RELATIVE_PATH CLSDF_PC_INCLUDEDIR ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_FULL_INCLUDEDIR})
# Libraries that a C++ compiler links by itself. A C compiler, as the linker of a mixed program, does not.
set(libraries ${CMAKE_CXX_IMPLICIT_LINK_LIBRARIES})
list(REMOVE_ITEM libraries gcc gcc_s c)
list(REMOVE_DUPLICATES libraries)
list(TRANSFORM libraries PREPEND -l)
list(JOIN libraries " " cxx_libraries)

# clsdf_install_targets(<target> <component>)
function(clsdf_install_targets target component)
  install(
    TARGETS ${target}
    EXPORT ${target}Targets
    LIBRARY COMPONENT ${component} NAMELINK_COMPONENT development
    ARCHIVE COMPONENT ${component}
    RUNTIME COMPONENT ${component}
    FILE_SET HEADERS COMPONENT development
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}) # for users' CMake before 3.23, which knows no file sets
  install(
    EXPORT ${target}Targets
    NAMESPACE clsdf::
    DESTINATION ${package_directory}
    COMPONENT development)
endfunction()

# clsdf_install_description(<target>): for pkg-config, of the variables PC_DESCRIPTION, PC_LIBRARIES, PC_LIBRARIES_PRIVATE and
# PC_REQUIRES.
function(clsdf_install_description target)
  string(REPLACE "_" "-" PC_NAME ${target})
  configure_file(cmake/library.pc.in ${PROJECT_BINARY_DIR}/${PC_NAME}.pc @ONLY)
  install(
    FILES ${PROJECT_BINARY_DIR}/${PC_NAME}.pc
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
    COMPONENT development)
endfunction()

# clsdf_install_library(<target> <component> <description> <pkg-config packages> <libraries> [<clsdf library>...]): packages
# and libraries are what a static library stands on, which it does not carry; then the libraries of clsdf that it links
# beside the core.
function(clsdf_install_library target component description packages libraries)
  clsdf_install_targets(${target} ${component})
  set(PC_DESCRIPTION "${description}")
  set(PC_LIBRARIES "-l${target}")
  set(PC_LIBRARIES_PRIVATE "")
  set(PC_REQUIRES "")
  if(NOT target STREQUAL "clsdf")
    set(PC_REQUIRES "clsdf = ${PROJECT_VERSION}")
  endif()
  foreach(library IN LISTS ARGN)
    set(PC_REQUIRES "${library} = ${PROJECT_VERSION} ${PC_REQUIRES}")
  endforeach()
  if(is_static)
    string(APPEND PC_REQUIRES " ${packages}")
    string(APPEND PC_LIBRARIES " ${libraries}")
  endif()
  set(PC_LIBRARIES_PRIVATE "${cxx_libraries}")
  clsdf_install_description(${target})
endfunction()

# clsdf_install_binding(<target> <component> <description> [<clsdf package>...]): a shared library whose programs need
# nothing of the C++ libraries.
function(clsdf_install_binding target component description)
  clsdf_install_targets(${target} ${component})
  set(PC_DESCRIPTION "${description}")
  set(PC_LIBRARIES "-l${target}")
  set(PC_LIBRARIES_PRIVATE "")
  set(PC_REQUIRES "")
  foreach(library IN LISTS ARGN)
    string(APPEND PC_REQUIRES " ${library} = ${PROJECT_VERSION}")
  endforeach()
  clsdf_install_description(${target})
endfunction()

# clsdf_install_fortran_source(<target> <description> [<clsdf package>...]): its descriptions, if only its source is installed.
function(clsdf_install_fortran_source target description)
  set(PC_DESCRIPTION "${description}")
  set(PC_LIBRARIES "")
  set(PC_LIBRARIES_PRIVATE "")
  list(TRANSFORM ARGN APPEND " = ${PROJECT_VERSION}")
  list(JOIN ARGN " " PC_REQUIRES)
  clsdf_install_description(${target})
  set(CLSDF_FORTRAN_TARGET ${target})
  string(REPLACE _fortran "" CLSDF_FORTRAN_SOURCE ${target})
  configure_file(cmake/clsdfFortran.cmake.in ${PROJECT_BINARY_DIR}/${target}Targets.cmake @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${target}Targets.cmake DESTINATION ${package_directory} COMPONENT development)
endfunction()

set(CLSDF_CONFIG_DEPENDENCIES "")
set(CLSDF_CONFIG_C meshes cuda)
set(CLSDF_CONFIG_C_IO io)
if(is_static)
  set(CLSDF_CONFIG_C "")
  set(CLSDF_CONFIG_C_IO "")
  foreach(package OpenCL TBB fmt)
    string(APPEND CLSDF_CONFIG_DEPENDENCIES "  find_dependency(${package})\n")
  endforeach()
endif()
set(CLSDF_COMPONENTS "")
clsdf_install_library(clsdf core "${PROJECT_DESCRIPTION}" "OpenCL tbb fmt mpfr gmp" "")
if(CLSDF_BUILD_MESHES)
  list(APPEND CLSDF_COMPONENTS meshes)
  clsdf_install_library(clsdf_meshes meshes "Files of meshes and points, and shapes, for clsdf" "tbb fmt mpfr gmp" "")
endif()
if(CLSDF_BUILD_IO)
  list(APPEND CLSDF_COMPONENTS io)
  # HDF5's own description has another name on every system.
  set(libraries "-l${CLSDF_HDF5_NAME}")
  if(CLSDF_WITH_OPENVDB)
    string(APPEND libraries " -lopenvdb -lImath")
  endif()
  clsdf_install_library(clsdf_io io "Files of fields, for clsdf" "tbb fmt expat zlib" "${libraries}" clsdf-meshes)
endif()
if(CLSDF_BUILD_CUDA)
  list(APPEND CLSDF_COMPONENTS cuda)
  clsdf_install_library(clsdf_cuda cuda "Memory of CUDA as inputs and outputs of clsdf" "OpenCL fmt" "")
endif()
if(CLSDF_BUILD_PAPERS)
  list(APPEND CLSDF_COMPONENTS papers)
  clsdf_install_library(clsdf_papers papers "The published methods that clsdf is compared with" "OpenCL tbb fmt mpfr gmp" "")
endif()
if(CLSDF_BUILD_PICTURE)
  list(APPEND CLSDF_COMPONENTS picture)
  clsdf_install_library(clsdf_picture picture "Pictures of clsdf's fields" "OpenCL tbb fmt cairo" "")
endif()
if(CLSDF_BUILD_REFERENCE)
  list(APPEND CLSDF_COMPONENTS reference)
  clsdf_install_library(clsdf_reference reference "The slow, plain specification of clsdf's fields, under the GPL"
                        "tbb fmt mpfr gmp" "")
endif()
if(CLSDF_BUILD_C)
  list(APPEND CLSDF_COMPONENTS c)
  clsdf_install_binding(clsdf_c c "clsdf in C: signed distance fields of triangle meshes")
  if(CLSDF_BUILD_IO)
    list(APPEND CLSDF_COMPONENTS c_io)
    clsdf_install_binding(clsdf_c_io c_io "Files of fields, for clsdf in C" clsdf-c)
  endif()
endif()
if(CLSDF_NO_FORTRAN)
  install(CODE "message(STATUS \"${CLSDF_NO_FORTRAN}\")" COMPONENT development)
endif()
file(RELATIVE_PATH sources ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_FULL_DATADIR}/clsdf/fortran)
set(PC_VARIABLES "sources=\${pcfiledir}/${sources}\n")
set(CLSDF_CONFIG_FORTRAN_SOURCES "")
if(CLSDF_BUILD_FORTRAN)
  # Modules of this compiler; and the sources, for every other one.
  set(PC_INCLUDE_FOLDER /clsdf/fortran)
  list(APPEND CLSDF_COMPONENTS fortran)
  clsdf_install_binding(clsdf_fortran fortran "clsdf in Fortran: signed distance fields of triangle meshes" clsdf-c)
  if(CLSDF_BUILD_IO)
    list(APPEND CLSDF_COMPONENTS fortran_io)
    clsdf_install_binding(clsdf_fortran_io fortran_io "Files of fields, for clsdf in Fortran" clsdf-fortran clsdf-c-io)
  endif()
  set(PC_INCLUDE_FOLDER "")
  get_target_property(modules clsdf_fortran Fortran_MODULE_DIRECTORY)
  install(
    DIRECTORY ${modules}/
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/clsdf/fortran
    COMPONENT development
    FILES_MATCHING
    PATTERN "*.mod")
elseif(CLSDF_BUILD_C)
  # Without a compiler the sources alone: clsdf::fortran compiles them in the project that uses it.
  file(RELATIVE_PATH CLSDF_CONFIG_FORTRAN_SOURCES ${CMAKE_INSTALL_FULL_LIBDIR}/cmake/clsdf
       ${CMAKE_INSTALL_FULL_DATADIR}/clsdf/fortran)
  list(APPEND CLSDF_COMPONENTS fortran)
  clsdf_install_fortran_source(clsdf_fortran "clsdf in Fortran, as a source: signed distance fields of triangle meshes" clsdf-c)
  if(CLSDF_BUILD_IO)
    list(APPEND CLSDF_COMPONENTS fortran_io)
    clsdf_install_fortran_source(clsdf_fortran_io "Files of fields, for clsdf in Fortran, as a source" clsdf-fortran clsdf-c-io)
  endif()
endif()
set(PC_VARIABLES "")
if(CLSDF_BUILD_C)
  # One file for a program that compiles the module itself.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS bindings/fortran/clsdf_c.f90 bindings/fortran/clsdf.f90)
  file(READ bindings/fortran/clsdf_c.f90 interface_of_c)
  file(READ bindings/fortran/clsdf.f90 module)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/fortran_source/clsdf.f90 CONTENT "${interface_of_c}\n${module}" @ONLY)
  install(
    FILES ${PROJECT_BINARY_DIR}/fortran_source/clsdf.f90 bindings/fortran/clsdf_io.f90
    DESTINATION ${CMAKE_INSTALL_DATADIR}/clsdf/fortran
    COMPONENT development)
endif()
if(CLSDF_BUILD_APPS)
  install(TARGETS clsdf_command COMPONENT command)
endif()
set(components core ${CLSDF_COMPONENTS})
list(JOIN components ", " CLSDF_COMPONENTS_TEXT)
list(JOIN CLSDF_COMPONENTS " " CLSDF_COMPONENTS)

configure_package_config_file(cmake/clsdfConfig.cmake.in ${PROJECT_BINARY_DIR}/clsdfConfig.cmake
                              INSTALL_DESTINATION ${package_directory} NO_SET_AND_CHECK_MACRO
                              NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/clsdfConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(
  FILES ${PROJECT_BINARY_DIR}/clsdfConfig.cmake ${PROJECT_BINARY_DIR}/clsdfConfigVersion.cmake
  DESTINATION ${package_directory}
  COMPONENT development)

# For PETSc and deal.II, which whoever includes them has.
install(
  DIRECTORY integrations/petsc/include/ integrations/dealii/include/
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT development)

# The licence goes with every component.
foreach(component core meshes io cuda papers picture reference c c_io fortran fortran_io command development)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT ${component})
endforeach()
# The documents, and all that they link to; another project that contains this one has documents of its own.
if(NOT PROJECT_IS_TOP_LEVEL)
  return()
endif()
install(FILES README.md CHANGELOG.md CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)
install(FILES conformance/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/conformance COMPONENT development)
install(
  DIRECTORY docs examples
  DESTINATION ${CMAKE_INSTALL_DOCDIR}
  COMPONENT development
  FILES_MATCHING
  PATTERN "*.md"
  PATTERN "*.png"
  PATTERN "*.cpp"
  PATTERN "*.hpp")
install(
  DIRECTORY bindings/c/examples
  DESTINATION ${CMAKE_INSTALL_DOCDIR}/bindings/c
  COMPONENT development
  FILES_MATCHING
  PATTERN "*.[ch]")
install(
  DIRECTORY bindings/fortran/examples
  DESTINATION ${CMAKE_INSTALL_DOCDIR}/bindings/fortran
  COMPONENT development
  FILES_MATCHING
  PATTERN "*.f90")
install(
  DIRECTORY benchmarks
  DESTINATION ${CMAKE_INSTALL_DOCDIR}
  COMPONENT development
  FILES_MATCHING
  PATTERN "*.md"
  PATTERN "HELD.tsv"
  PATTERN "peers" EXCLUDE
  PATTERN "plot" EXCLUDE)
