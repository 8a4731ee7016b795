# Run at every build: commit and date of SOURCE -> OUTPUT, a header that changes only with them. If SOURCE is under no
# version control of its own, they are those of the source archive. In a copy of other origin the commit is empty and the
# date today's, or that of SOURCE_DATE_EPOCH.
cmake_minimum_required(VERSION 3.25)

function(ask_git result)
  execute_process(
    COMMAND git ${ARGN}
    WORKING_DIRECTORY ${SOURCE}
    OUTPUT_VARIABLE output
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  set(${result} "${output}" PARENT_SCOPE)
endfunction()

string(TIMESTAMP date %Y-%m-%d UTC)
set(commit "")
if(EXISTS ${SOURCE}/.git)
  ask_git(commit describe --always --dirty --abbrev=12)
  ask_git(commit_date log -1 --format=%cs)
  if(commit_date)
    set(date ${commit_date})
  endif()
else()
  # git archive puts them there.
  file(READ ${CMAKE_CURRENT_LIST_DIR}/archived_commit.txt archived)
  if(archived MATCHES "^([0-9a-f]+) ([0-9-]+)\n")
    string(SUBSTRING ${CMAKE_MATCH_1} 0 12 commit)
    set(date ${CMAKE_MATCH_2})
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#pragma once

#define CLSDF_COMMIT \"@commit@\"
#define CLSDF_DATE \"@date@\"
" @ONLY)
