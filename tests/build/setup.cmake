# CLSDF: the sources; SCRATCH: a directory of this test's own.
#
# scripts/setup on machines that are made up of a few programs: what a release of Debian does not have, or cannot install,
# ends the set-up only if the build needs it.
cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE ${SCRATCH})
function(program name text)
  file(WRITE ${SCRATCH}/bin/${name} "#!/bin/sh\n${text}\n")
  file(CHMOD ${SCRATCH}/bin/${name} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
endfunction()

# Root, nothing is installed at first, one package is unknown and another one has dependencies that cannot be had.
program(id "echo 0")
program(dpkg-query "for p; do :; done; grep -qx $p '${SCRATCH}/installed' && echo installed")
program(apt-cache "for p; do :; done; [ $p != oclgrind ]")
program(
  apt-get
  "verb=; for p; do case $p in
    update | install) verb=$p ;;
    -* | *=*) ;;
    oclgrind | teem-apps | \"$BROKEN\") exit 100 ;;
    *) echo $p >>'${SCRATCH}/try' ;;
  esac; done
  [ $verb = update ] || cat '${SCRATCH}/try' >>'${SCRATCH}/installed'; rm -f '${SCRATCH}/try'; echo \"$*\" >>'${SCRATCH}/calls'")
function(setup status log)
  file(REMOVE ${SCRATCH}/calls)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env PATH=${SCRATCH}/bin:$ENV{PATH} ${CLSDF}/scripts/setup ${ARGN}
    RESULT_VARIABLE result
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  set(${status} ${result} PARENT_SCOPE)
  set(${log} "${output}" PARENT_SCOPE)
endfunction()

file(WRITE ${SCRATCH}/installed "")
setup(status log --tests)
if(NOT status EQUAL 0 OR NOT log MATCHES "has no oclgrind teem-apps: the tests that need")
  message(SEND_ERROR "What the tests alone need ends the set-up, or is not named: ${status}, ${log}")
endif()
file(STRINGS ${SCRATCH}/installed installed)
foreach(package cmake libopenvdb-dev python3-vtk9 clang libopenmpi-dev openmpi-bin libhdf5-openmpi-dev)
  if(NOT package IN_LIST installed)
    message(SEND_ERROR "${package} is not installed, although it can be had")
  endif()
endforeach()

# Everything that can be had is there: no rights are needed for an unknown package.
file(APPEND ${SCRATCH}/installed "teem-apps\n")
program(id "echo 1000")
program(sudo "exit 1")
setup(status log --tests)
if(NOT status EQUAL 0 OR EXISTS ${SCRATCH}/calls OR NOT log MATCHES "has no oclgrind")
  message(SEND_ERROR "An unknown package asks for rights: ${status}, ${log}")
endif()

# A package of the build ends it, with the command to run.
program(id "echo 0")
file(WRITE ${SCRATCH}/installed "")
set(ENV{BROKEN} libcgal-dev)
setup(status log)
if(NOT status EQUAL 2 OR NOT log MATCHES "apt-get install -y --no-install-recommends .*libcgal-dev")
  message(SEND_ERROR "A set-up without libcgal-dev ends with ${status}: ${log}")
endif()

# For another processor: its libraries, the compilers and tools of this one, and no clang that would displace them.
program(dpkg "echo dpkg \"$*\" >>'${SCRATCH}/calls'")
program(dpkg-deb "echo dpkg-deb \"$*\" >>'${SCRATCH}/calls'")
file(WRITE ${SCRATCH}/installed "")
set(ENV{BROKEN} "")
setup(status log --arm64)
file(STRINGS ${SCRATCH}/installed installed)
file(READ ${SCRATCH}/calls calls)
if(NOT status EQUAL 0 OR NOT calls MATCHES "^dpkg --add-architecture arm64\n.*dpkg-deb .*\ndpkg -i .*install")
  message(SEND_ERROR "A set-up for aarch64 ends with ${status}, ${log}, after ${calls}")
endif()
foreach(package cmake libeigen3-dev crossbuild-essential-arm64 qemu-user-static libcgal-dev:arm64 pocl-opencl-icd:arm64)
  if(NOT package IN_LIST installed)
    message(SEND_ERROR "${package} is not installed for aarch64")
  endif()
endforeach()
if(libcgal-dev IN_LIST installed)
  message(SEND_ERROR "This machine's libraries are installed for aarch64")
endif()
