# The packages that the library is built with. An absent one is named as Debian names it.
#
# clsdf_require(<package> <Debian package> [<argument of find_package>...])
macro(clsdf_require package debian_package)
  find_package(${package} QUIET ${ARGN})
  if(NOT ${package}_FOUND)
    message(FATAL_ERROR "clsdf needs ${package}, which CMake did not find.\n"
                        "On Debian and its kin: apt-get install ${debian_package} "
                        "(scripts/setup installs everything).")
  endif()
endmacro()

# A project that adds this one as a subdirectory links what clsdf::clsdf links, so it must see these targets.
set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL TRUE)
set(CGAL_DO_NOT_WARN_ABOUT_CMAKE_BUILD_TYPE TRUE)

# CONFIG: CGAL brings find modules of its own for Eigen and TBB, which define other targets.
clsdf_require(CGAL libcgal-dev CONFIG)
clsdf_require(Eigen3 libeigen3-dev CONFIG)
clsdf_require(TBB libtbb-dev CONFIG)
clsdf_require(fmt libfmt-dev CONFIG)
# A system's fmt is compiled for the types of its standard library, which on Linux is not libc++.
include(CheckCXXSymbolExists)
check_cxx_symbol_exists(_LIBCPP_VERSION version CLSDF_HAS_LIBCXX)
set(CLSDF_FMT fmt::fmt)
if(CLSDF_HAS_LIBCXX)
  set(CLSDF_FMT fmt::fmt-header-only)
endif()
clsdf_require(OpenCL ocl-icd-opencl-dev)

find_path(CLSDF_OPENCL_CXX_BINDING CL/opencl.hpp HINTS ${OpenCL_INCLUDE_DIRS})
mark_as_advanced(CLSDF_OPENCL_CXX_BINDING)
if(NOT CLSDF_OPENCL_CXX_BINDING)
  message(FATAL_ERROR "clsdf needs OpenCL's C++ binding (CL/opencl.hpp), which CMake did not find.\n"
                      "On Debian and its kin: apt-get install opencl-clhpp-headers "
                      "(scripts/setup installs everything).")
endif()

# The formats of clsdf::io. The command describes its results in JSON, too.
if(CLSDF_BUILD_IO OR CLSDF_BUILD_APPS OR CLSDF_BUILD_TESTS)
  clsdf_require(nlohmann_json nlohmann-json3-dev CONFIG)
endif()
if(CLSDF_BUILD_IO)
  clsdf_require(EXPAT libexpat1-dev)
  clsdf_require(ZLIB zlib1g-dev)

  # Not find_package(HDF5), which compiles with C or asks a wrapper of a compiler; Debian's name is for the serial library.
  find_path(CLSDF_HDF5_INCLUDE hdf5.h PATH_SUFFIXES hdf5/serial)
  find_library(CLSDF_HDF5_LIBRARY NAMES hdf5_serial hdf5)
  mark_as_advanced(CLSDF_HDF5_INCLUDE CLSDF_HDF5_LIBRARY)
  if(NOT CLSDF_HDF5_INCLUDE OR NOT CLSDF_HDF5_LIBRARY)
    message(FATAL_ERROR "clsdf needs HDF5 (hdf5.h and its library), which CMake did not find.\n"
                        "On Debian and its kin: apt-get install libhdf5-dev "
                        "(scripts/setup installs everything; -DCLSDF_BUILD_IO=OFF -DCLSDF_BUILD_APPS=OFF "
                        "-DCLSDF_BUILD_TESTS=OFF builds the other libraries).")
  endif()
  add_library(clsdf_hdf5 INTERFACE)
  target_include_directories(clsdf_hdf5 SYSTEM INTERFACE ${CLSDF_HDF5_INCLUDE})
  target_link_libraries(clsdf_hdf5 INTERFACE ${CLSDF_HDF5_LIBRARY})
  # As whoever links a static clsdf names it.
  get_filename_component(CLSDF_HDF5_NAME ${CLSDF_HDF5_LIBRARY} NAME_WE)
  string(REGEX REPLACE "^lib" "" CLSDF_HDF5_NAME ${CLSDF_HDF5_NAME})

  # Nor OpenVDB's own module, which wants the development files of everything that OpenVDB itself is built with.
  if(CLSDF_WITH_OPENVDB)
    find_path(CLSDF_OPENVDB_INCLUDE openvdb/openvdb.h)
    find_library(CLSDF_OPENVDB_LIBRARY openvdb)
    find_library(CLSDF_IMATH_LIBRARY Imath) # halves, in OpenVDB's headers
    mark_as_advanced(CLSDF_OPENVDB_INCLUDE CLSDF_OPENVDB_LIBRARY CLSDF_IMATH_LIBRARY)
    if(NOT CLSDF_OPENVDB_INCLUDE OR NOT CLSDF_OPENVDB_LIBRARY OR NOT CLSDF_IMATH_LIBRARY)
      message(FATAL_ERROR "CLSDF_WITH_OPENVDB is ON, and CMake did not find OpenVDB.\n"
                          "On Debian and its kin: apt-get install libopenvdb-dev (scripts/setup --openvdb installs it; "
                          "-DCLSDF_WITH_OPENVDB=OFF does without .vdb files).")
    endif()
    add_library(clsdf_openvdb INTERFACE)
    target_include_directories(clsdf_openvdb SYSTEM INTERFACE ${CLSDF_OPENVDB_INCLUDE})
    target_link_libraries(clsdf_openvdb INTERFACE ${CLSDF_OPENVDB_LIBRARY} ${CLSDF_IMATH_LIBRARY} TBB::tbb)
  endif()
endif()

if(CLSDF_BUILD_PICTURE)
  clsdf_require(PkgConfig pkg-config)
  pkg_check_modules(cairo QUIET IMPORTED_TARGET GLOBAL cairo-pdf)
  if(NOT cairo_FOUND)
    message(FATAL_ERROR "clsdf's pictures need cairo, which CMake did not find.\n"
                        "On Debian and its kin: apt-get install libcairo2-dev "
                        "(scripts/setup installs everything; with -DCLSDF_BUILD_PICTURE=OFF the command draws "
                        "no pictures).")
  endif()
endif()
