# WAY: find_package, add_subdirectory or pkg_config; CLSDF: the sources; BUILD: their build tree; SCRATCH: a directory of
# this test's own; GENERATOR, COMPILER and LAUNCHER: as the library was built.
cmake_minimum_required(VERSION 3.25)

set(prefix ${SCRATCH}/prefix)
set(source ${CLSDF}/tests/consumer)
set(program ${SCRATCH}/build/consumer)
file(REMOVE_RECURSE ${SCRATCH})
file(MAKE_DIRECTORY ${SCRATCH}/build)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

if(NOT WAY STREQUAL "add_subdirectory")
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
endif()

if(WAY STREQUAL "pkg_config")
  file(GLOB_RECURSE description ${prefix}/clsdf.pc)
  get_filename_component(directory "${description}" DIRECTORY)
  set(ENV{PKG_CONFIG_PATH} ${directory})
  execute_process(
    COMMAND pkg-config --cflags --libs clsdf
    OUTPUT_VARIABLE flags
    COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  get_filename_component(ENV{LD_LIBRARY_PATH} "${directory}" DIRECTORY)
  run(${COMPILER} -std=c++20 ${source}/consumer.cpp ${flags} -o ${program})

  # CGAL is how the library works, not what it offers.
  execute_process(
    COMMAND ${COMPILER} -std=c++20 ${source}/consumer.cpp ${flags} -M
    OUTPUT_VARIABLE dependencies
    COMMAND_ERROR_IS_FATAL ANY)
  if(dependencies MATCHES "[^ ]+/CGAL/[^ ]+")
    message(FATAL_ERROR "A program that includes clsdf/clsdf.hpp gets ${CMAKE_MATCH_0}")
  endif()
else()
  set(arguments -DWAY=${WAY} -DCLSDF=${CLSDF} -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${COMPILER}
                -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} -DCMAKE_BUILD_TYPE=Debug -G ${GENERATOR})
  if(WAY STREQUAL "find_package")
    list(APPEND arguments -DCMAKE_DISABLE_FIND_PACKAGE_CGAL=ON)
  endif()
  run(${CMAKE_COMMAND} -S ${source} -B ${SCRATCH}/build ${arguments})
  run(${CMAKE_COMMAND} --build ${SCRATCH}/build)
endif()
run(${program})
if(WAY STREQUAL "find_package")
  run(${program}_reference)
endif()
