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
set(refusing bundle bundle-driver conformance debian-packages fetch-meshes figures fit-figure format gallery gpu-compile gpu-counts nightly on-arm on-debian
             on-opencl python-tests real-meshes release same-bytes setup site tidy try-debian try-debian-packages walk wheel)
if(NOT EXISTS /usr/bin/python3)
  list(REMOVE_ITEM scripts figures gpu-compile nightly)
  list(REMOVE_ITEM refusing figures gpu-compile nightly)
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
foreach(script demo far-field gpu-counts peers-points python-peers)
  run(${script} "no such mesh.off")
  if(NOT status EQUAL 3 OR NOT errors STREQUAL "${script}: no such file: no such mesh.off\n")
    message(SEND_ERROR "scripts/${script} with a mistyped mesh ends with ${status}: ${output}${errors}")
  endif()
endforeach()

file(GLOB made RELATIVE "${tree}" "${tree}/*")
if(NOT made STREQUAL "scripts")
  message(SEND_ERROR "the scripts made ${made}")
endif()

file(MAKE_DIRECTORY "${SCRATCH}/programs")

# The sources of the bundled driver are files of known contents. Without them one line says what is needed. The machine of
# the test has all packages, and its apt is configured for no archive.
file(COPY "${CLSDF}/packaging" DESTINATION "${tree}")
foreach(program IN ITEMS "uname:echo Linux x86_64" "dpkg-query:echo installed" apt-cache: apt-get:)
  string(REGEX MATCH "^([^:]*):(.*)$" program "${program}")
  file(WRITE "${SCRATCH}/programs/${CMAKE_MATCH_1}" "#!/bin/sh\n${CMAKE_MATCH_2}\n")
  file(CHMOD "${SCRATCH}/programs/${CMAKE_MATCH_1}" PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
endforeach()
# expect_no_sources(<message> <option>...)
function(expect_no_sources message)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env "PATH=${SCRATCH}/programs:$ENV{PATH}" "CLSDF_OPENCL_FOLDER=${SCRATCH}/opencl"
            "${tree}/scripts/bundle-driver" ${ARGN} "${SCRATCH}/driver"
    RESULT_VARIABLE status
    OUTPUT_VARIABLE output
    ERROR_VARIABLE errors)
  if(NOT status EQUAL 2 OR NOT output STREQUAL "" OR NOT errors MATCHES "^scripts/bundle-driver: [^\n]*${message}[^\n]*\n$")
    message(SEND_ERROR "scripts/bundle-driver ${ARGN} ends with ${status}: ${output}${errors}")
  endif()
endfunction()
expect_no_sources("apt has no source of Debian's package pocl 6.0-6.*--sources.*pocl_6.0-6.dsc")
file(MAKE_DIRECTORY "${SCRATCH}/sources")
expect_no_sources("sources has no pocl_6.0-6.dsc" --sources "${SCRATCH}/sources")
file(WRITE "${SCRATCH}/sources/pocl_6.0-6.dsc" "another text")
expect_no_sources("pocl_6.0-6.dsc is damaged" --sources "${SCRATCH}/sources")
expect_no_sources("would delete" --sources "${SCRATCH}/opencl/pocl-6-bundled")

# scripts/try-debian with a stand-in for the tree: its commands end with the status that the environment gives. If no tree
# can be made or entered, or if packages cannot be fetched, the trial is not run. All else that fails is a failure.
file(WRITE "${SCRATCH}/programs/unshare" "#!/bin/sh
case \"$*\" in
  *'chroot / true') echo 'not permitted' >&2; exit \${NAMESPACES:-0} ;;
  *scripts/setup) printf '%b' \"$SETUP_SAYS\" >&2; exit \${SETUP:-0} ;;
  *'cmake --build'*) exit \${BUILD:-0} ;;
  *'clsdf check'*) exit \${FIELD:-0} ;;
esac
exit 1
")
file(CHMOD "${SCRATCH}/programs/unshare" PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
file(MAKE_DIRECTORY "${SCRATCH}/trees/13/etc")
# expect_trial(<user number> <status> <last line> <variable=value>...)
function(expect_trial user expected_status line)
  file(WRITE "${SCRATCH}/programs/id" "#!/bin/sh\necho ${user}\n")
  file(CHMOD "${SCRATCH}/programs/id" PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  execute_process(
    COMMAND
      ${CMAKE_COMMAND} -E env "PATH=${SCRATCH}/programs:$ENV{PATH}" "GIT_CEILING_DIRECTORIES=${SCRATCH}" CCACHE_DISABLE=1
      "CLSDF_DEBIAN_TREES=${SCRATCH}/trees" ${ARGN} "${tree}/scripts/try-debian"
    RESULT_VARIABLE status
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  if(NOT status EQUAL expected_status OR NOT output MATCHES "(^|\n)Debian 13: ${line}\n$")
    message(SEND_ERROR "try-debian as user ${user} with ${ARGN} ends with ${status}: ${output}")
  endif()
endfunction()
expect_trial(0 0 "passed at unknown in [0-9]+ s")
expect_trial(1000 0 "NOT RUN, because only root can make a system and enter it")
expect_trial(0 0 "NOT RUN, because this machine does not let root mount and chroot in namespaces: not permitted" NAMESPACES=1)
expect_trial(0 0 "NOT RUN, because the folder could not be mounted" SETUP=125
             "SETUP_SAYS=scripts/on-debian: the folder could not be mounted\\n")
set(fetch "E: Failed to fetch http://a/b")
set(locate "E: Unable to locate package libnew-dev")
expect_trial(0 0 "NOT RUN, because its packages could not be installed: ${fetch}" SETUP=2 "SETUP_SAYS=${fetch}\\n${locate}\\n")
expect_trial(0 1 "FAILED at unknown: scripts/setup names a package that Debian 13 does not have" SETUP=2 "SETUP_SAYS=${locate}\\n")
expect_trial(0 1 "FAILED at unknown: scripts/setup ended with status 1" SETUP=1)
foreach(status 1 2 125)
  expect_trial(0 1 "FAILED at unknown: the sources do not compile there" BUILD=${status})
  expect_trial(0 1 "FAILED at unknown: a program on the library does not run there, or a field could not be computed, or is wrong"
               FIELD=${status})
endforeach()
