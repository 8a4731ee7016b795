# SOURCE: the source tree.
#
# Files of the core include only files of their own folder and of the folders before it. The build keeps a part of these
# borders, too: it gives foundations and the engine no other include folders.
cmake_minimum_required(VERSION 3.25)

set(allowed "")
set(found 0)

# check_folder(<folder>): in `allowed` are the names of folders, or of files, that its files may include. Other names are
# an error if they are in `known`.
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

# The core's folders, in order.
set(folders foundations/core foundations/device)
foreach(stage launch mesh lattice frusta tree lists sign finish bricks plan)
  list(APPEND folders engine/${stage})
endforeach()
list(APPEND folders targets points checks calls)

# What is in lib, and the folders beside the core.
file(GLOB all RELATIVE ${SOURCE}/lib LIST_DIRECTORIES true ${SOURCE}/lib/* ${SOURCE}/lib/foundations/* ${SOURCE}/lib/engine/*)
list(FILTER all EXCLUDE REGEX "^(CMakeLists.txt|foundations|engine|include|io|papers|picture|reference|tools)$")
foreach(folder ${all})
  if(NOT folder IN_LIST folders)
    message(SEND_ERROR "lib/${folder} is not among the folders of ${CMAKE_CURRENT_LIST_FILE}")
  endif()
endforeach()

set(known ${folders} foundations engine io papers picture reference tools)
list(TRANSFORM known REPLACE ".*/" "")
foreach(folder ${folders})
  get_filename_component(name ${folder} NAME)
  list(APPEND allowed ${name})
  check_folder(${SOURCE}/lib/${folder})
endforeach()

# The engine's face: calls include nothing else of it. In plan/ are KeptMesh, which prepares a mesh for a grid, and
# GridPlan, which plans and runs.
set(allowed core device plan launch mesh targets points checks calls)
check_folder(${SOURCE}/lib/calls)

# Tools for meshes, beside the core.
set(allowed core mesh tools)
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
