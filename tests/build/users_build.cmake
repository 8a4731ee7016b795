# CLSDF: the sources; SCRATCH: a directory of this test's own.
#
# What a user gets who configures with the preset "release" and asks for nothing: no warning ends the build, the static
# library can go into a shared one, and OpenVDB is not used, installed or not. Asked for and not there, it is an error
# that says what to install.
cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE ${SCRATCH})
function(configure folder status log)
  execute_process(
    COMMAND ${CMAKE_COMMAND} --preset release -S ${CLSDF} -B ${SCRATCH}/${folder} -DCLSDF_BUILD_TESTS=OFF ${ARGN}
    WORKING_DIRECTORY ${CLSDF}
    RESULT_VARIABLE result
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  set(${status} ${result} PARENT_SCOPE)
  set(${log} "${output}" PARENT_SCOPE)
endfunction()

configure(plain status log)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${log}")
endif()
file(READ ${SCRATCH}/plain/compile_commands.json commands)
foreach(absent "-Werror" "vdb_write.cpp")
  string(FIND "${commands}" "${absent}" place)
  if(NOT place EQUAL -1)
    message(SEND_ERROR "The preset \"release\" compiles with ${absent}")
  endif()
endforeach()
foreach(present "-Wall" "-fPIC" "vdb_absent.cpp")
  string(FIND "${commands}" "${present}" place)
  if(place EQUAL -1)
    message(SEND_ERROR "The preset \"release\" compiles without ${present}")
  endif()
endforeach()

# As on a machine without OpenVDB: CMake does not search for a variable that has a value.
configure(without status log -DCLSDF_WITH_OPENVDB=ON -DCLSDF_OPENVDB_INCLUDE=)
string(REGEX REPLACE "[ \n]+" " " log "${log}")
if(status EQUAL 0 OR NOT log MATCHES "CLSDF_WITH_OPENVDB is ON.*libopenvdb-dev.*scripts/setup --openvdb")
  message(SEND_ERROR "Without OpenVDB, CLSDF_WITH_OPENVDB=ON does not say what to install: ${log}")
endif()

# Without the published methods there are the libraries and the command; the tests need them.
configure(core status log -DCLSDF_BUILD_PAPERS=OFF)
if(NOT status EQUAL 0)
  message(SEND_ERROR "CLSDF_BUILD_PAPERS=OFF does not configure: ${log}")
endif()
file(READ ${SCRATCH}/core/compile_commands.json commands)
string(FIND "${commands}" "lib/papers/method.cpp" place)
if(NOT place EQUAL -1)
  message(SEND_ERROR "CLSDF_BUILD_PAPERS=OFF compiles lib/papers/method.cpp")
endif()
configure(core_tests status log -DCLSDF_BUILD_PAPERS=OFF -DCLSDF_BUILD_TESTS=ON)
if(status EQUAL 0 OR NOT log MATCHES "CLSDF_BUILD_TESTS=OFF")
  message(SEND_ERROR "CLSDF_BUILD_PAPERS=OFF with tests does not say what to do: ${log}")
endif()
