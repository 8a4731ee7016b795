# CLSDF: the sources; LIBRARY: libclsdf_disguise; SCRATCH: a directory of this test's own.
#
# scripts/on-opencl refuses another version of PoCL than the one that its name promises.
cmake_minimum_required(VERSION 3.25)

get_filename_component(folder "${LIBRARY}" DIRECTORY)
get_filename_component(name "${LIBRARY}" NAME)
# expect(<implementation> <status>): PoCL answers as version 3.0.
function(expect implementation expected)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -E env "CLSDF_OPENCL_FOLDER=${SCRATCH}" "LD_LIBRARY_PATH=${folder}:$ENV{LD_LIBRARY_PATH}"
            LD_PRELOAD=${name} CLSDF_DISGUISE=pocl-3.0 ASAN_OPTIONS=verify_asan_link_order=0:detect_leaks=0
            "${CLSDF}/scripts/on-opencl" ${implementation} true
    RESULT_VARIABLE status
    ERROR_VARIABLE errors)
  if(NOT status EQUAL ${expected})
    message(SEND_ERROR "scripts/on-opencl ${implementation} ends with ${status}: ${errors}")
  elseif(expected EQUAL 2 AND NOT errors MATCHES "is needed, and this one is installed: OpenCL 3.0 PoCL 3.0-rc2")
    message(SEND_ERROR "scripts/on-opencl ${implementation} says: ${errors}")
  endif()
endfunction()
expect(installed 0)
expect(installed-pocl-3.0 0)
expect(installed-pocl-3 0)
foreach(version 3.1 6 0 3.00)
  expect(installed-pocl-${version} 2)
endforeach()
file(GLOB vendors /etc/OpenCL/vendors/*.icd)
foreach(vendor IN LISTS vendors)
  file(READ "${vendor}" library)
  if(library MATCHES "libpocl")
    expect(pocl-3.1 2)
    break()
  endif()
endforeach()
