# SOURCE: the source tree.
#
# Files of the core include only files of their own folder and of the folders before it, and of kernels/ those of the
# stages up to their own. The build keeps a part of these borders, too: it gives foundations and the engine no other
# include folders.
cmake_minimum_required(VERSION 3.25)

set(allowed "")
set(found 0)

# check_folder(<folder>): its files may include what `allowed` names, of all that `known` names: folders of lib, headers
# of kernels, and public headers as "clsdf/grid.hpp".
function(check_folder folder)
  file(GLOB_RECURSE files ${folder}/*.[ch]pp ${folder}/*.h ${folder}/*.cl)
  foreach(file ${files})
    file(STRINGS ${file} includes REGEX "^[ \t]*#[ \t]*include")
    foreach(include ${includes})
      if(NOT include MATCHES "^#include [<\"]" OR include MATCHES "\"(\\.|clsdf/)")
        message(SEND_ERROR "${file}: ${include}\nwrite #include \"folder/file\" or #include <clsdf/file>")
      endif()
      if(NOT include MATCHES "\"([^\"/]+)|<(clsdf/[a-z_]+\\.h)")
        continue()
      endif()
      set(name "${CMAKE_MATCH_1}")
      if(name STREQUAL "")
        string(REGEX MATCH "clsdf/[a-z_.]+" name "${include}")
      endif()
      if(NOT name IN_LIST allowed AND name IN_LIST known)
        message(SEND_ERROR "${file}: ${include}\nit may include these only: ${allowed}")
      endif()
      math(EXPR found "${found} + 1")
    endforeach()
  endforeach()
  set(found ${found} PARENT_SCOPE)
endfunction()

# The core's folders, in order.
set(folders foundations/core foundations/device)
foreach(stage launch homes mesh surface topology lattice frusta tree lists sign finish bricks plan)
  list(APPEND folders engine/${stage})
endforeach()
list(APPEND folders cutting targets points scenes segments checks plans calls)

# What is in lib, and the folders beside the core.
file(GLOB all RELATIVE ${SOURCE}/lib LIST_DIRECTORIES true ${SOURCE}/lib/* ${SOURCE}/lib/foundations/* ${SOURCE}/lib/engine/*)
list(FILTER all EXCLUDE REGEX "^(CMakeLists.txt|cuda|foundations|engine|include|io|papers|picture|reference|tools)$")
foreach(folder ${all})
  if(NOT folder IN_LIST folders)
    message(SEND_ERROR "lib/${folder} is not among the folders of ${CMAKE_CURRENT_LIST_FILE}")
  endif()
endforeach()

# The folders of kernels, in order.
file(STRINGS ${SOURCE}/cmake/EmbedKernels.cmake kernel_folders REGEX "^set\\(CLSDF_KERNEL_FOLDERS ")
string(REGEX REPLACE "^set\\(CLSDF_KERNEL_FOLDERS (.*)\\)$" "\\1" kernel_folders "${kernel_folders}")
separate_arguments(kernel_folders)
set(stages ${folders})
list(TRANSFORM stages REPLACE ".*/" "")
list(FILTER stages INCLUDE REGEX "^(topology|frusta|tree|lists|sign|finish|bricks|cutting|targets|points|segments)$")
if(NOT "common;${stages}" STREQUAL "${kernel_folders}")
  message(SEND_ERROR "the folders of kernels are ${kernel_folders}; by the order of lib they would be common;${stages}")
endif()

# allow_kernels(<folder>): from here on, headers of kernels/<folder> may be included.
macro(allow_kernels folder)
  file(GLOB headers RELATIVE ${SOURCE}/kernels/${folder} ${SOURCE}/kernels/${folder}/*.h)
  list(APPEND allowed ${headers})
endmacro()

file(GLOB all_kernels RELATIVE ${SOURCE}/kernels ${SOURCE}/kernels/*/*.h)
file(GLOB public_headers RELATIVE ${SOURCE}/lib/include ${SOURCE}/lib/include/clsdf/*)
set(known ${folders} foundations engine cuda io papers picture reference tools ${all_kernels})
list(TRANSFORM known REPLACE ".*/" "")
list(APPEND known ${public_headers})

# The public headers: those of the core that every layer may include, the faces of the top layers, and those beside the core,
# which the core does not include. Each is in one of the lists.
set(public_of_core arrays.hpp calls.hpp device.hpp error.hpp export.hpp field.hpp fractions.hpp grid.hpp mesh.hpp outer.hpp output_table.h outputs.hpp
                   row_tables.hpp segments.hpp sparse.hpp topology.hpp topology_table.h tuning.hpp turn_to_compile.hpp version.hpp)
set(face_of_plans fraction_plan.hpp link_plan.hpp plan.hpp point_plan.hpp sparse_plan.hpp)
set(face clsdf.hpp distance_transform.hpp scene.hpp)
set(beside cuda.hpp eigen.hpp io.hpp mesh_files.hpp openvdb.hpp papers.hpp part_files.hpp picture.hpp reference.hpp)
foreach(list public_of_core face_of_plans face beside)
  list(TRANSFORM ${list} PREPEND clsdf/)
endforeach()
set(named ${public_of_core} ${face_of_plans} ${face} ${beside})
foreach(header ${public_headers} ${named})
  set(count ${named})
  list(FILTER count INCLUDE REGEX "^${header}$")
  list(LENGTH count count)
  if(NOT header IN_LIST public_headers OR NOT count EQUAL 1)
    message(SEND_ERROR "${header}: each public header is once in public_of_core, face_of_plans, face or beside")
  endif()
endforeach()
set(allowed ${public_of_core})

allow_kernels(common)
foreach(folder ${folders})
  get_filename_component(name ${folder} NAME)
  list(APPEND allowed ${name})
  if(name IN_LIST kernel_folders)
    allow_kernels(${name})
  endif()
  if(name STREQUAL plans)
    list(APPEND allowed ${face_of_plans})
  elseif(name STREQUAL calls)
    list(APPEND allowed ${face})
  endif()
  check_folder(${SOURCE}/lib/${folder})
endforeach()

# The engine's face: plans and calls include nothing else of it. In plan/ are KeptMesh, which prepares a mesh for a grid,
# and GridPlan, which plans and runs.
set(allowed ${public_of_core} ${face_of_plans} core device plan launch mesh surface cutting targets points scenes segments checks plans)
allow_kernels(targets)
check_folder(${SOURCE}/lib/plans)
list(APPEND allowed ${face} calls)
check_folder(${SOURCE}/lib/calls)

# The rooms of calls, in order: each includes its own files, those of transform and those of no room, which belong to every
# call; scenes, which are asked as single meshes are, includes all.
set(rooms transform fields points segments fractions scenes)
file(GLOB files RELATIVE ${SOURCE}/lib/calls ${SOURCE}/lib/calls/*.[ch]pp ${SOURCE}/lib/calls/*/*.[ch]pp)
set(found_in_calls 0)
foreach(file ${files})
  get_filename_component(room ${file} DIRECTORY)
  if(room STREQUAL "")
    set(seen "")
  elseif(room STREQUAL scenes)
    set(seen ${rooms})
  elseif(room IN_LIST rooms)
    set(seen transform ${room})
  else()
    message(SEND_ERROR "lib/calls/${room} is not among the rooms of ${CMAKE_CURRENT_LIST_FILE}: ${rooms}")
  endif()
  file(STRINGS ${SOURCE}/lib/calls/${file} includes REGEX "^#include \"calls/[a-z_]+/")
  foreach(include ${includes})
    string(REGEX MATCH "calls/([a-z_]+)/" ignored "${include}")
    if(NOT CMAKE_MATCH_1 IN_LIST seen)
      message(SEND_ERROR "lib/calls/${file}: ${include}\nit may include these rooms only: ${seen}")
    endif()
    math(EXPR found_in_calls "${found_in_calls} + 1")
  endforeach()
endforeach()
if(found_in_calls LESS 20)
  message(SEND_ERROR "only ${found_in_calls} includes between the rooms of calls were found")
endif()

# Tools for meshes, beside the core.
set(allowed ${public_of_core} clsdf/mesh_files.hpp core mesh tools)
check_folder(${SOURCE}/lib/tools)

# Memory of CUDA, beside the core.
set(allowed ${public_of_core} clsdf/cuda.hpp device cuda)
check_folder(${SOURCE}/lib/cuda)

# Files of kernels.
set(allowed clsdf/output_table.h)
foreach(folder ${kernel_folders})
  allow_kernels(${folder})
  check_folder(${SOURCE}/kernels/${folder})
endforeach()
if(found LESS 800)
  message(SEND_ERROR "only ${found} includes were found")
endif()
