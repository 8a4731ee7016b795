# BUILD: the build tree, by Ninja; SCRATCH: a directory of this test's own.
#
# 1. With the library's own compiler command, a GPL header of CGAL does not compile, an LGPL one does.
# 2. No object of the library, or of another one that is not clsdf::reference, was compiled with a file of CGAL whose licence is the
#    GPL, by Ninja's record. That also finds what 1 cannot: headers without the guard, and sources that get around it.
cmake_minimum_required(VERSION 3.25)

set(lgpl_header CGAL/Exact_predicates_inexact_constructions_kernel.h)
set(gpl_headers CGAL/AABB_tree.h CGAL/Surface_mesh.h CGAL/Polygon_mesh_processing/self_intersections.h)

file(READ ${BUILD}/compile_commands.json database)
string(JSON count LENGTH "${database}")
math(EXPR last "${count} - 1")
set(command "")
foreach(index RANGE ${last})
  string(JSON source GET "${database}" ${index} file)
  if(source MATCHES "/lib/engine/mesh/predicates\\.cpp$")
    string(JSON command GET "${database}" ${index} command)
    # The rest of the command: the compiler, definitions, directories and options.
    string(REGEX REPLACE " -o [^ ]+ -c .*$" "" command "${command}")
    separate_arguments(command UNIX_COMMAND "${command}")
    break()
  endif()
endforeach()
if(NOT command)
  message(FATAL_ERROR "${BUILD}/compile_commands.json does not have lib/engine/mesh/predicates.cpp")
endif()

# compiles(<header> <variable> <log>): does an #include of it compile with the library's command?
function(compiles header result log)
  file(WRITE ${SCRATCH}/probe.cpp "#include <${header}>\n")
  execute_process(
    COMMAND ${command} -Wfatal-errors -fsyntax-only ${SCRATCH}/probe.cpp
    RESULT_VARIABLE status
    ERROR_VARIABLE message)
  if(status EQUAL 0)
    set(${result} TRUE PARENT_SCOPE)
  else()
    set(${result} FALSE PARENT_SCOPE)
  endif()
  set(${log} "${message}" PARENT_SCOPE)
endfunction()

compiles(${lgpl_header} compiled log)
if(NOT compiled)
  message(FATAL_ERROR "${lgpl_header} should compile in the library:\n${log}")
endif()
foreach(header IN LISTS gpl_headers)
  compiles(${header} compiled log)
  if(compiled)
    message(SEND_ERROR "${header}, which is under the GPL, compiles in the library")
  elseif(NOT log MATCHES "CGAL_LICENSE_ERROR")
    message(SEND_ERROR "${header} fails for another reason than its licence:\n${log}")
  endif()
endforeach()

# Ninja's record: objects, each with the files that it was made from.
execute_process(
  COMMAND ninja -C ${BUILD} -t deps
  OUTPUT_VARIABLE record
  ERROR_VARIABLE error
  RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "ninja -t deps fails in ${BUILD}: ${error}")
endif()
string(REGEX REPLACE "[];[]" "" record "${record}")
string(REPLACE "\n\n" ";" record "${record}")
set(objects 0)
set(judged "")
foreach(made IN LISTS record)
  string(REGEX MATCH "^[^:]+" object "${made}")
  if(NOT object MATCHES "^lib/CMakeFiles/clsdf_[a-z]+\\.dir/" OR object MATCHES "clsdf_reference\\.dir/")
    continue()
  endif()
  math(EXPR objects "${objects} + 1")
  string(REGEX MATCHALL "[^ \n]+/CGAL/[^ \n]+" headers "${made}")
  foreach(header IN LISTS headers)
    cmake_path(ABSOLUTE_PATH header BASE_DIRECTORY "${BUILD}" NORMALIZE)
    if(header IN_LIST judged)
      continue()
    endif()
    list(APPEND judged ${header})
    file(STRINGS ${header} gpl REGEX "SPDX-License-Identifier: GPL" LIMIT_COUNT 1)
    if(gpl)
      message(SEND_ERROR "${object} was made with ${header}, which is under the GPL")
      break()
    endif()
  endforeach()
endforeach()
list(LENGTH judged header_count)
if(objects EQUAL 0 OR header_count EQUAL 0)
  message(FATAL_ERROR "Ninja's record has ${objects} objects of the libraries with ${header_count} files of CGAL")
endif()
message(STATUS "${objects} objects of the libraries were made with ${header_count} files of CGAL, none under the GPL")
