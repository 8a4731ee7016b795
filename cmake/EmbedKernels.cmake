# The kernels of the core, a folder for each stage, in an order in which a folder includes files of the folders before it. A
# file's name is unique among them: kernels and the host include it by its name alone.
set(CLSDF_KERNEL_FOLDERS common topology frusta tree lists sign finish bricks cutting targets points segments)
list(TRANSFORM CLSDF_KERNEL_FOLDERS PREPEND ${PROJECT_SOURCE_DIR}/kernels/)
# Those whose headers the host includes outside their own layer, too.
set(CLSDF_SHARED_KERNEL_FOLDERS ${CLSDF_KERNEL_FOLDERS})
list(FILTER CLSDF_SHARED_KERNEL_FOLDERS EXCLUDE REGEX "/cutting$")

# clsdf_embed_kernels(<target> <file>...): the kernels' sources become strings of the library, so that nothing is looked
# for at run time: clsdf::kernels::files in its "kernel_sources.hpp", a table of file names and texts.
set(CLSDF_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/embed_kernels_script.cmake)

function(clsdf_embed_kernels target)
  set(directory ${CMAKE_CURRENT_BINARY_DIR}/embedded/${target})
  set(output ${directory}/kernel_sources.hpp)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} "-DINPUTS=${ARGN}" -DOUTPUT=${output} -P ${CLSDF_EMBED_SCRIPT}
    DEPENDS ${ARGN} ${CLSDF_EMBED_SCRIPT}
    COMMENT "Embedding the kernels"
    VERBATIM)
  target_sources(${target} PRIVATE ${output})
  target_include_directories(${target} BEFORE PRIVATE ${directory})
  set_target_properties(${target} PROPERTIES CLSDF_KERNEL_SOURCES ${directory})
endfunction()
