# clsdf_embed_kernels(<target> <file>...): the kernels' sources become strings of the library, declared in
# "kernel_sources.hpp" as clsdf::kernels::<name without ending>; nothing is looked for at run time.
set(CLSDF_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/embed_kernels_script.cmake)

function(clsdf_embed_kernels target)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/kernel_sources.hpp)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} "-DINPUTS=${ARGN}" -DOUTPUT=${output} -P ${CLSDF_EMBED_SCRIPT}
    DEPENDS ${ARGN} ${CLSDF_EMBED_SCRIPT}
    VERBATIM)
  target_sources(${target} PRIVATE ${output})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR})
endfunction()
