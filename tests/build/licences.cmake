# BUILD: the build tree; SCRATCH: a directory of this test's own.
#
# 1. With the library's own compiler command, a GPL header of CGAL does not compile, an LGPL one does.
# 2. No source of the library, or of clsdf::papers, sees a file of CGAL whose licence is the GPL. That also finds what 1 cannot: headers
#    without the guard, and sources that get around it.
cmake_minimum_required(VERSION 3.25)

set(lgpl_header CGAL/Exact_predicates_inexact_constructions_kernel.h)
set(gpl_headers CGAL/AABB_tree.h CGAL/Surface_mesh.h CGAL/Polygon_mesh_processing/self_intersections.h)

file(READ ${BUILD}/compile_commands.json database)
string(JSON count LENGTH "${database}")
math(EXPR last "${count} - 1")
set(sources "")
foreach(index RANGE ${last})
  string(JSON command GET "${database}" ${index} command)
  if(command MATCHES "CMakeFiles/clsdf(_papers)?\\.dir/")
    string(JSON source GET "${database}" ${index} file)
    # The rest of the command: the compiler, definitions, directories and options.
    string(REGEX REPLACE " -o [^ ]+ -c .*$" "" command "${command}")
    separate_arguments(command UNIX_COMMAND "${command}")
    list(APPEND sources ${source})
    set("command of ${source}" ${command})
  endif()
endforeach()
if(NOT sources)
  message(FATAL_ERROR "${BUILD}/compile_commands.json has no source of the library")
endif()

# compiles(<header> <variable> <log>): does an #include of it compile with the library's command?
list(GET sources 0 any_source)
function(compiles header result log)
  file(WRITE ${SCRATCH}/probe.cpp "#include <${header}>\n")
  execute_process(
    COMMAND ${command\ of\ ${any_source}} -Wfatal-errors -fsyntax-only ${SCRATCH}/probe.cpp
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

set(judged "")
foreach(source IN LISTS sources)
  execute_process(
    COMMAND ${command\ of\ ${source}} -M ${source}
    OUTPUT_VARIABLE dependencies
    COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^ \n\\]+/CGAL/[^ \n\\]+" headers "${dependencies}")
  foreach(header IN LISTS headers)
    if(header IN_LIST judged)
      continue()
    endif()
    list(APPEND judged ${header})
    file(STRINGS ${header} gpl REGEX "SPDX-License-Identifier: GPL" LIMIT_COUNT 1)
    if(gpl)
      message(SEND_ERROR "${source} includes ${header}, which is under the GPL")
      break()
    endif()
  endforeach()
endforeach()
list(LENGTH sources source_count)
list(LENGTH judged header_count)
message(STATUS "${source_count} sources of the library include ${header_count} files of CGAL, none under the GPL")
