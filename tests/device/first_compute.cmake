# The library alone prints nothing, writes no file, and obeys no variable for tests, unless the program asks for it.
# PROGRAM: first_compute;
# SCRATCH: a directory of this test's own. POCL_CACHE_DIR names another one.
cmake_minimum_required(VERSION 3.25)

# compute(<argument>...): sets output and files: all paths below the folders in which a library may write.
function(compute)
  file(REMOVE_RECURSE ${SCRATCH})
  file(MAKE_DIRECTORY ${SCRATCH}/home ${SCRATCH}/cache ${SCRATCH}/current)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env HOME=${SCRATCH}/home XDG_CACHE_HOME=${SCRATCH}/cache CLSDF_CACHE_DIR=${SCRATCH}/own
            CLSDF_SELF_TEST=0 CLSDF_MAX_ALLOCATION=1 ${PROGRAM} ${ARGN}
    WORKING_DIRECTORY ${SCRATCH}/current
    OUTPUT_VARIABLE output COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
  message("${output}")
  file(GLOB_RECURSE files LIST_DIRECTORIES true ${SCRATCH}/*)
  list(REMOVE_ITEM files ${SCRATCH}/home ${SCRATCH}/cache ${SCRATCH}/current)
  set(files "${files}" PARENT_SCOPE)
  set(output "${output}" PARENT_SCOPE)
endfunction()

# Compilers of OpenCL print warnings on standard error. Programs are compiled anew: by one process, and by two at once.
set(program ${CMAKE_COMMAND} -E env POCL_CACHE_DIR=${SCRATCH}/kernels XDG_CACHE_HOME=${SCRATCH}/kernels ${PROGRAM})
file(REMOVE_RECURSE ${SCRATCH})
execute_process(COMMAND ${program} ERROR_VARIABLE errors COMMAND_ERROR_IS_FATAL ANY)
file(REMOVE_RECURSE ${SCRATCH})
execute_process(COMMAND ${CMAKE_COMMAND} -E env POCL_CACHE_DIR=${SCRATCH}/kernels XDG_CACHE_HOME=${SCRATCH}/kernels
                        sh -c "\"$0\" & first=$!; \"$0\" && wait $first" ${PROGRAM}
                ERROR_VARIABLE errors_of_two COMMAND_ERROR_IS_FATAL ANY)
if(NOT "${errors}${errors_of_two}" STREQUAL "")
  message(SEND_ERROR "A first run wrote this on standard error:\n${errors}${errors_of_two}")
endif()

compute()
if(files)
  message(SEND_ERROR "The library wrote ${files}")
endif()
if(output MATCHES "not tested")
  message(SEND_ERROR "CLSDF_SELF_TEST=0 turned the test off, and the program did not ask for it")
endif()

compute(--keep-records)
if(NOT files MATCHES "${SCRATCH}/own/[0-9a-f]+.tested")
  message(SEND_ERROR "No record is in CLSDF_CACHE_DIR, and the program asked for it: ${files}")
endif()
