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

# A nightly run passes if each of its steps passed. The step `systems` counts if it has run or if it can, for root.
file(WRITE "${tree}/scripts/test" "#!/bin/sh\n")
file(MAKE_DIRECTORY "${SCRATCH}/programs")
# expect_verdict(<user number> <line of systems or ""> <verdict>)
function(expect_verdict user systems verdict)
  file(WRITE "${SCRATCH}/programs/id" "#!/bin/sh\necho ${user}\n")
  file(CHMOD "${SCRATCH}/programs/id" "${tree}/scripts/test" PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  file(WRITE "${tree}/benchmarks/NIGHTLY.md" "# Nightly runs\n")
  file(REMOVE_RECURSE "${tree}/build")
  foreach(step sanitize threads fuzz faults acceptance disguise wheel packages)
    file(WRITE "${tree}/build/nightly/${step}.line" "- ${step}: passed at unknown-dirty, 0:00:01; \n")
  endforeach()
  if(systems)
    file(WRITE "${tree}/build/nightly/systems.line" "- systems: ${systems}, 0:00:01; \n")
  endif()
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env "PATH=${SCRATCH}/programs:$ENV{PATH}" "GIT_CEILING_DIRECTORIES=${SCRATCH}"
            "${tree}/scripts/nightly" suite
    WORKING_DIRECTORY "${tree}"
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  file(STRINGS "${tree}/benchmarks/NIGHTLY.md" titles REGEX "^## ")
  if(NOT titles MATCHES "^## Commit unknown-dirty, .*: ${verdict}$")
    message(SEND_ERROR "user ${user}, systems \"${systems}\": \"${titles}\" instead of ${verdict}: ${output}")
  endif()
endfunction()
expect_verdict(0 "passed at unknown-dirty" passed)
expect_verdict(0 "FAILED at unknown-dirty" FAILED)
expect_verdict(0 "" incomplete)
expect_verdict(1000 "" passed)
expect_verdict(1000 "FAILED at unknown-dirty" FAILED)
expect_verdict(1000 "passed at another" incomplete)

# The end of a nightly run names the steps that passed at none of the last 300 commits, as the record in git has it: build
# folders do not last. Each step's line is in the record when the step ends, and those of an earlier run at the same commit
# stay, without its build folder.
find_program(git git)
if(git)
  file(REMOVE_RECURSE "${tree}/build")
  file(WRITE "${tree}/.gitignore" "/build/\n")
  # This step passes if the record has that of the step before it.
  file(WRITE "${tree}/scripts/accept" "#!/bin/sh\ngrep -q '^- suite: passed, 0:00:0' benchmarks/NIGHTLY.md\n")
  file(CHMOD "${tree}/scripts/accept" PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  set(history "")
  foreach(n RANGE 1 302)
    string(APPEND history "commit refs/heads/main\ncommitter a <a@b> ${n} +0000\ndata 0\n\n")
  endforeach()
  file(WRITE "${SCRATCH}/history" "${history}")
  # in_tree(<variable> <argument>...) sets the variable to the output of git.
  macro(in_tree variable)
    execute_process(
      COMMAND ${git} -c user.name=a -c user.email=a@b ${ARGN}
      WORKING_DIRECTORY "${tree}"
      INPUT_FILE "${SCRATCH}/history"
      OUTPUT_VARIABLE ${variable}
      OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  endmacro()
  in_tree(ignored init --quiet --initial-branch=main)
  in_tree(ignored fast-import --quiet)
  in_tree(ignored add .)
  in_tree(ignored commit --quiet --message=tree)
  foreach(age 0 300 301 302)
    in_tree(age_${age} rev-parse --short HEAD~${age})
  endforeach()
  file(WRITE "${tree}/benchmarks/NIGHTLY.md"
       "# Nightly runs\n
## Commit ${age_0}, 2026-11-02 00:00 UTC: FAILED\n\na machine\n
- threads: FAILED, 0:00:01; 1 test\n- faults: passed at ${age_300}, 0:00:01; 1 test\n- disguise: not run\n
## Commit ${age_301}, 2026-11-01 00:00 UTC: FAILED\n\na machine\n
- sanitize: FAILED, 0:00:01; 1 test\n- threads: passed, 0:00:01; 1 test\n- fuzz: passed at ${age_302}, 0:00:01; 1 file
- disguise: passed at ${age_300}-dirty, 0:00:01; 1 test\n")
  execute_process(
    COMMAND "${tree}/scripts/nightly" suite acceptance
    WORKING_DIRECTORY "${tree}"
    RESULT_VARIABLE status
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  set(expected "")
  foreach(step sanitize disguise wheel packages systems)
    string(APPEND expected "- ${step}: no commit at which it passed is known\n")
  endforeach()
  string(APPEND expected "- fuzz: passed 302 commits ago, at ${age_302}\n- threads: passed 301 commits ago, at ${age_301}\n")
  if(NOT status EQUAL 0 OR NOT output MATCHES "\nPassed at none of the last 300 commits:\n${expected}$")
    message(SEND_ERROR "scripts/nightly ends with ${status} and names other steps than\n${expected}: ${output}")
  endif()
  file(READ "${tree}/benchmarks/NIGHTLY.md" record)
  if(NOT record MATCHES "Commit ${age_0}, [^\n]*: FAILED\n.*- suite: passed, .*- threads: FAILED, 0:00:01; 1 test
- fuzz: not run\n- faults: passed at ${age_300}, 0:00:01; 1 test\n- acceptance: passed, .*Commit ${age_301}")
    message(SEND_ERROR "scripts/nightly writes the record ${record}")
  endif()
  file(REMOVE_RECURSE "${tree}/.git" "${tree}/build")
endif()

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
