# CLSDF: the sources; SCRATCH: a directory of this test's own.
#
# Every script of scripts/ explains itself (--help, -h) without starting work: in a tree that has nothing but the scripts it
# makes no file and succeeds. Arguments that a script does not take end it with status 2.
cmake_minimum_required(VERSION 3.25)

set(tree "${SCRATCH}/a tree")
file(REMOVE_RECURSE "${SCRATCH}")
file(COPY "${CLSDF}/scripts" DESTINATION "${tree}")
# run(<script> <argument>...) sets status, output and errors.
macro(run script)
  execute_process(
    COMMAND "${tree}/scripts/${script}" ${ARGN}
    WORKING_DIRECTORY "${tree}"
    RESULT_VARIABLE status
    OUTPUT_VARIABLE output
    ERROR_VARIABLE errors
    TIMEOUT 20)
endmacro()

file(GLOB scripts RELATIVE "${tree}/scripts" "${tree}/scripts/*")
list(FILTER scripts EXCLUDE REGEX "\\.bash$")
list(LENGTH scripts count)
if(count LESS 15)
  message(SEND_ERROR "only ${count} scripts were found")
endif()
set(refusing bundle fetch-meshes figures format gallery gpu-compile gpu-counts nightly on-debian on-opencl setup tidy)
if(NOT EXISTS /usr/bin/python3)
  list(REMOVE_ITEM scripts figures gpu-compile)
  list(REMOVE_ITEM refusing figures gpu-compile)
endif()
foreach(script IN LISTS scripts)
  foreach(option --help -h)
    run(${script} ${option})
    if(NOT status EQUAL 0 OR output STREQUAL "" OR NOT errors STREQUAL "")
      message(SEND_ERROR "scripts/${script} ${option} ends with ${status}: ${output}${errors}")
    endif()
  endforeach()
endforeach()

foreach(script IN LISTS refusing)
  run(${script} --nonsense)
  if(NOT status EQUAL 2 OR NOT output STREQUAL "" OR errors STREQUAL "")
    message(SEND_ERROR "scripts/${script} --nonsense ends with ${status}: ${output}${errors}")
  endif()
endforeach()

# A mistyped mesh ends a script before it sets the machine up and builds.
foreach(script demo gpu-counts peers-points)
  run(${script} "no such mesh.off")
  if(NOT status EQUAL 3 OR NOT errors STREQUAL "${script}: no such file: no such mesh.off\n")
    message(SEND_ERROR "scripts/${script} with a mistyped mesh ends with ${status}: ${output}${errors}")
  endif()
endforeach()

file(GLOB made RELATIVE "${tree}" "${tree}/*")
if(NOT made STREQUAL "scripts")
  message(SEND_ERROR "the scripts made ${made}")
endif()
