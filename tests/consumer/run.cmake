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
  get_filename_component(ENV{LD_LIBRARY_PATH} "${directory}" DIRECTORY)
  function(flags_of_clsdf result)
    execute_process(
      COMMAND pkg-config ${ARGN} clsdf
      OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE
      COMMAND_ERROR_IS_FATAL ANY)
    separate_arguments(flags UNIX_COMMAND "${flags}")
    set(${result} ${flags} PARENT_SCOPE)
  endfunction()
  flags_of_clsdf(flags --cflags --libs)

  # The line of the README, as a reader would paste it; c++ is the compiler that the library was built with.
  file(STRINGS ${CLSDF}/README.md line REGEX "^c\\+\\+ .*pkg-config" LIMIT_COUNT 1)
  string(REGEX REPLACE "^c\\+\\+" "${COMPILER}" line "${line}")
  file(COPY_FILE ${source}/consumer.cpp ${SCRATCH}/build/simulation.cpp)
  execute_process(COMMAND sh -c "${line}" WORKING_DIRECTORY ${SCRATCH}/build COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
  file(RENAME ${SCRATCH}/build/simulation ${program})

  # Linked by a C compiler, with what its description says of a static library.
  flags_of_clsdf(static_flags --static --libs)
  run(${COMPILER} -std=c++20 -DCONSUMER_OF_C -c ${source}/consumer.cpp ${flags} -o ${program}.o)
  run(cc ${source}/main.c ${program}.o ${static_flags} -o ${program}_of_c)
  run(${program}_of_c)

  # The version is the same in the header, in the library and in the description.
  flags_of_clsdf(version --modversion)
  execute_process(COMMAND ${program} OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
  if(NOT output MATCHES "^clsdf ${version}: ")
    message(FATAL_ERROR "pkg-config says version ${version}, the program '${output}'")
  endif()

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
