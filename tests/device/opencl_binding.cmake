# A static library defines no symbol of OpenCL's C++ binding: a program's own copy has namespace cl (lib/foundations/device/opencl_binding.hpp).
# NM; LIBRARIES: divided by commas.
cmake_minimum_required(VERSION 3.25)

string(REPLACE "," ";" LIBRARIES "${LIBRARIES}")
foreach(library IN LISTS LIBRARIES)
  execute_process(COMMAND ${NM} --defined-only ${library} OUTPUT_VARIABLE symbols ERROR_QUIET COMMAND_ERROR_IS_FATAL ANY)
  if(NOT symbols MATCHES "N8clsdf_cl")
    message(SEND_ERROR "${library} does not use OpenCL's binding, or under another name")
  endif()
  # A nested name, also in a template argument: St6vectorIN2cl6Device.
  if(symbols MATCHES "[^\n]* ([^\n ]*NK?2cl[0-9A-Z][^\n]*)")
    message(SEND_ERROR "${library} defines ${CMAKE_MATCH_1}")
  endif()
endforeach()
