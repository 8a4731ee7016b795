# CLSDF: the sources; SCRATCH: a directory of this test's own.
#
# The build of a user who configures with the preset "release" and no option: no warning ends the build, the static
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
foreach(absent "-Werror " "/vdb_write.cpp") # a package asks for -Werror=format-security
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

# If programs are to be built that link a library, the library cannot be left out. The message names the options to add,
# and they suffice.
foreach(library IO PAPERS REFERENCE)
  set(option -DCLSDF_BUILD_${library}=OFF)
  configure(without_${library} status log ${option} -DCLSDF_BUILD_TESTS=ON)
  string(REGEX REPLACE "[ \n]+" " " log "${log}")
  if(status EQUAL 0 OR NOT log MATCHES "with ${option}, configure with(( -DCLSDF_BUILD_[A-Z]+=OFF)+)")
    message(SEND_ERROR "${option} with tests and command does not say what to do: ${log}")
    continue()
  endif()
  separate_arguments(more UNIX_COMMAND "${CMAKE_MATCH_1}")
  configure(without_${library} status log ${option} -DCLSDF_BUILD_TESTS=ON ${more})
  if(NOT status EQUAL 0)
    message(SEND_ERROR "${option} ${more} does not configure: ${log}")
  endif()
endforeach()

# Without the published methods, the reference and cairo there are the libraries and the command, and nothing of it sees a
# GPL header.
foreach(library papers:method reference:oracle picture:canvas)
  string(REPLACE ":" ";" library ${library})
  list(POP_FRONT library name source)
  string(TOUPPER ${name} upper)
  configure(without_${name} status log -DCLSDF_BUILD_${upper}=OFF)
  if(NOT status EQUAL 0)
    message(SEND_ERROR "CLSDF_BUILD_${upper}=OFF does not configure: ${log}")
    continue()
  endif()
  file(READ ${SCRATCH}/without_${name}/compile_commands.json commands)
  foreach(present "lib/${name}/absent.cpp" "apps/clsdf/main.cpp")
    string(FIND "${commands}" "${present}" place)
    if(place EQUAL -1)
      message(SEND_ERROR "CLSDF_BUILD_${upper}=OFF does not compile ${present}")
    endif()
  endforeach()
  string(FIND "${commands}" "lib/${name}/${source}.cpp" place)
  if(NOT place EQUAL -1)
    message(SEND_ERROR "CLSDF_BUILD_${upper}=OFF compiles lib/${name}/${source}.cpp")
  endif()
endforeach()
file(READ ${SCRATCH}/without_reference/compile_commands.json commands)
string(JSON count LENGTH "${commands}")
math(EXPR last "${count} - 1")
foreach(index RANGE ${last})
  string(JSON source GET "${commands}" ${index} file)
  string(JSON command GET "${commands}" ${index} command)
  if(source MATCHES "cgal_tree" OR NOT command MATCHES "-DCGAL_LICENSE_ERROR=1")
    message(SEND_ERROR "CLSDF_BUILD_REFERENCE=OFF compiles ${source}, which may see a GPL header: ${command}")
    break()
  endif()
endforeach()
