# SOURCE: the source tree.
#
# border(<layer> <folder>...): a file of lib/<layer>/<folder> includes only files of the folders of its own layer up to
# its own, and of the layers before it. The build keeps the borders between layers, too: it gives a layer the include
# folders of those that it may see. Between the folders of a layer this test alone does.
cmake_minimum_required(VERSION 3.25)

set(allowed "")
set(found 0)
set(layers "")

# check_folder(<folder>): in `allowed` are the names of folders that its files may include.
function(check_folder folder)
  file(GLOB files ${folder}/*.[ch]pp ${folder}/*.h ${folder}/*.cl)
  foreach(file ${files})
    file(STRINGS ${file} includes REGEX "^#include \"")
    foreach(include ${includes})
      string(REGEX MATCH "\"([^\"/]+)" whole "${include}")
      set(name "${CMAKE_MATCH_1}")
      if(NOT name IN_LIST allowed AND name IN_LIST known)
        message(SEND_ERROR "${file}: ${include}\nit may include files of these only: ${allowed}")
      endif()
      math(EXPR found "${found} + 1")
    endforeach()
  endforeach()
  set(found ${found} PARENT_SCOPE)
endfunction()

file(GLOB known RELATIVE ${SOURCE}/lib ${SOURCE}/lib/*/*)
list(TRANSFORM known REPLACE ".*/" "")

macro(border layer)
  list(APPEND layers ${layer})
  foreach(folder ${ARGN})
    list(APPEND allowed ${folder})
    check_folder(${SOURCE}/lib/${layer}/${folder})
  endforeach()
endmacro()

border(foundations core device)
border(engine mesh polyhedra launch prepare scan plan)
border(outputs targets)
border(queries points)
border(checks self_test)
border(calls transform)

# The list names every folder of the core.
foreach(layer ${layers})
  file(GLOB folders RELATIVE ${SOURCE}/lib/${layer} ${SOURCE}/lib/${layer}/*)
  foreach(folder ${folders})
    if(NOT folder IN_LIST allowed)
      message(SEND_ERROR "lib/${layer}/${folder} is in no border of ${CMAKE_CURRENT_LIST_FILE}")
    endif()
  endforeach()
endforeach()

# The engine's face: calls include nothing else of it. In plan/ are KeptMesh, which prepares a mesh for a grid, and
# GridPlan, which plans and runs.
set(allowed core device plan launch mesh targets points self_test transform)
check_folder(${SOURCE}/lib/calls/transform)

# Tools for meshes, beside the core.
set(allowed core mesh)
check_folder(${SOURCE}/lib/tools)

# The kernels' folders, whose files are included by their names alone.
file(STRINGS ${SOURCE}/cmake/EmbedKernels.cmake kernel_folders REGEX "^set\\(CLSDF_KERNEL_FOLDERS ")
string(REGEX REPLACE "^set\\(CLSDF_KERNEL_FOLDERS (.*)\\)$" "\\1" kernel_folders "${kernel_folders}")
separate_arguments(kernel_folders)
file(GLOB known RELATIVE ${SOURCE}/kernels ${SOURCE}/kernels/*/*.h)
list(TRANSFORM known REPLACE ".*/" "")
set(allowed "")
foreach(folder ${kernel_folders})
  file(GLOB headers RELATIVE ${SOURCE}/kernels/${folder} ${SOURCE}/kernels/${folder}/*.h)
  list(APPEND allowed ${headers})
  check_folder(${SOURCE}/kernels/${folder})
endforeach()
if(found LESS 500)
  message(SEND_ERROR "only ${found} includes were found")
endif()
