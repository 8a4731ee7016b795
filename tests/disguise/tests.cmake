# A library between a program and the loader of OpenCL (disguise.hpp): a processor as a GPU with memory of its own,
# counts of what is asked of the driver, and calls that fail on purpose.
add_library(clsdf_disguise SHARED ${CMAKE_CURRENT_LIST_DIR}/record.cpp ${CMAKE_CURRENT_LIST_DIR}/gpu.cpp
                                  ${CMAKE_CURRENT_LIST_DIR}/memory.cpp ${CMAKE_CURRENT_LIST_DIR}/calls.cpp
                                  ${CMAKE_CURRENT_LIST_DIR}/external.cpp)
target_include_directories(clsdf_disguise PUBLIC ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(clsdf_disguise PRIVATE clsdf_warnings nlohmann_json::nlohmann_json ${CMAKE_DL_LIBS})

# A stand-in for CUDA's driver, libcuda.so.1, in a folder of its own.
add_library(clsdf_cuda SHARED ${CMAKE_CURRENT_LIST_DIR}/cuda/driver.cpp ${CMAKE_CURRENT_LIST_DIR}/cuda/streams.cpp)
target_include_directories(clsdf_cuda PRIVATE ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(clsdf_cuda PRIVATE clsdf_warnings Threads::Threads)
set_target_properties(clsdf_cuda PROPERTIES OUTPUT_NAME cuda VERSION 1 SOVERSION 1
                                            LIBRARY_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/cuda)

# clsdf_between(<test>...): the library lies between these tests' programs and the loader. LD_PRELOAD is split at blanks,
# LD_LIBRARY_PATH is not.
function(clsdf_between)
  set(modification LD_LIBRARY_PATH=path_list_prepend:$<TARGET_FILE_DIR:clsdf_disguise>
                   ASAN_OPTIONS=string_append::verify_asan_link_order=0)
  set_tests_properties(${ARGN} PROPERTIES ENVIRONMENT LD_PRELOAD=$<TARGET_FILE_NAME:clsdf_disguise>
                                          ENVIRONMENT_MODIFICATION "${modification}")
endfunction()

clsdf_test(disguise_promises ${CMAKE_CURRENT_LIST_DIR}/promises.cpp)
target_link_libraries(test_disguise_promises PRIVATE clsdf_disguise clsdf::reference clsdf::papers OpenCL::OpenCL)
clsdf_between(disguise_promises)

clsdf_test(disguise_device_meshes ${CMAKE_CURRENT_LIST_DIR}/device_meshes.cpp)
target_link_libraries(test_disguise_device_meshes PRIVATE clsdf_disguise clsdf::reference OpenCL::OpenCL)
clsdf_between(disguise_device_meshes)

clsdf_test(disguise_pinned_reads ${CMAKE_CURRENT_LIST_DIR}/pinned_reads.cpp)
target_link_libraries(test_disguise_pinned_reads PRIVATE clsdf_disguise OpenCL::OpenCL)
clsdf_between(disguise_pinned_reads)

# PoCL answers as other drivers do.
clsdf_test(disguise_drivers ${CMAKE_CURRENT_LIST_DIR}/drivers.cpp)
target_link_libraries(test_disguise_drivers PRIVATE clsdf_disguise OpenCL::OpenCL)
clsdf_between(disguise_drivers)

# A GPU that takes memory of CUDA.
clsdf_test(disguise_external_memory ${CMAKE_CURRENT_LIST_DIR}/external_memory.cpp)
target_link_libraries(test_disguise_external_memory PRIVATE clsdf_disguise OpenCL::OpenCL)
clsdf_between(disguise_external_memory)

# The program behind scripts/gpu-counts.
add_executable(gpu_counts ${CMAKE_CURRENT_LIST_DIR}/gpu_counts.cpp)
target_link_libraries(gpu_counts PRIVATE clsdf_warnings clsdf_disguise clsdf::io clsdf_internals Eigen3::Eigen OpenCL::OpenCL ${CLSDF_FMT} nlohmann_json::nlohmann_json)
target_include_directories(gpu_counts PRIVATE ${PROJECT_SOURCE_DIR}/tests)
set(CLSDF_CUBQL "" CACHE PATH "The sources of cuBQL, whose search gpu_counts then counts, too")
mark_as_advanced(CLSDF_CUBQL)
if(CLSDF_CUBQL)
  target_sources(gpu_counts PRIVATE ${CMAKE_CURRENT_LIST_DIR}/cubql_search.cpp)
  # Its headers would not pass our warnings.
  target_include_directories(gpu_counts SYSTEM PRIVATE ${CLSDF_CUBQL})
  target_compile_definitions(gpu_counts PRIVATE CLSDF_TEST_CUBQL)
endif()

if(TARGET clsdf_command)
  add_test(NAME gpu_counts
           COMMAND ${CMAKE_COMMAND} -DCLSDF=${PROJECT_SOURCE_DIR} -DBUILD=${PROJECT_BINARY_DIR} -DPROGRAM=$<TARGET_FILE:clsdf_command>
                   -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/gpu_counts_files -P ${CMAKE_CURRENT_LIST_DIR}/gpu_counts.cmake)
  set_tests_properties(gpu_counts PROPERTIES ENVIRONMENT_MODIFICATION ASAN_OPTIONS=string_append::verify_asan_link_order=0)
endif()

find_package(Python3 QUIET COMPONENTS Interpreter)
if(Python3_Interpreter_FOUND)
  add_test(NAME on_opencl
           COMMAND ${CMAKE_COMMAND} -DCLSDF=${PROJECT_SOURCE_DIR} -DLIBRARY=$<TARGET_FILE:clsdf_disguise>
                   -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/on_opencl -P ${CMAKE_CURRENT_LIST_DIR}/on_opencl.cmake)
endif()

find_file(CLSDF_OCLGRIND_DRIVER liboclgrind-rt-icd.so PATH_SUFFIXES lib/oclgrind lib64/oclgrind)
mark_as_advanced(CLSDF_OCLGRIND_DRIVER)

# The command with calls that fail: a sample, and with -C nightly each call.
if(TARGET clsdf_command)
  clsdf_test(disguise_faults ${CMAKE_CURRENT_LIST_DIR}/faults.cpp)
  add_dependencies(test_disguise_faults clsdf_command clsdf_disguise)
  target_compile_definitions(
    test_disguise_faults PRIVATE CLSDF_COMMAND="$<TARGET_FILE:clsdf_command>"
                                 CLSDF_DISGUISE_LIBRARY="$<TARGET_FILE:clsdf_disguise>")
  target_link_libraries(test_disguise_faults PRIVATE clsdf_disguise nlohmann_json::nlohmann_json)
  # About 200 processes. The seed is fixed, so that no change fails by chance; the nightly test leaves no call out.
  set_tests_properties(disguise_faults PROPERTIES TIMEOUT 900 ENVIRONMENT CLSDF_FAULT_SEED=1)

  # Drivers that are not registered. The second of two in a process is oclgrind: LLVM ends a process with two of PoCL.
  add_library(clsdf_refused_driver MODULE ${CMAKE_CURRENT_LIST_DIR}/refused_driver.cpp)
  target_link_libraries(clsdf_refused_driver PRIVATE clsdf_warnings)
  clsdf_test(unregistered_drivers ${CMAKE_CURRENT_LIST_DIR}/unregistered_drivers.cpp)
  add_dependencies(test_unregistered_drivers clsdf_command clsdf_disguise clsdf_refused_driver)
  target_compile_definitions(
    test_unregistered_drivers
    PRIVATE CLSDF_COMMAND="$<TARGET_FILE:clsdf_command>" CLSDF_DISGUISE_LIBRARY="$<TARGET_FILE:clsdf_disguise>"
            CLSDF_REFUSED_DRIVER="$<TARGET_FILE:clsdf_refused_driver>"
            CLSDF_OCLGRIND_DRIVER="$<$<BOOL:${CLSDF_OCLGRIND_DRIVER}>:${CLSDF_OCLGRIND_DRIVER}>")
  target_link_libraries(test_unregistered_drivers PRIVATE nlohmann_json::nlohmann_json ${CMAKE_DL_LIBS})
  set_tests_properties(unregistered_drivers PROPERTIES ENVIRONMENT_MODIFICATION
                                                       ASAN_OPTIONS=string_append::verify_asan_link_order=0)

  add_test(NAME disguise_is_complete
           COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DPROGRAM=$<TARGET_FILE:clsdf_command>
                   -DLIBRARY=$<TARGET_FILE:clsdf_disguise> -P ${CMAKE_CURRENT_LIST_DIR}/complete.cmake)
  add_test(NAME disguise_every_fault COMMAND test_disguise_faults --color_output=no CONFIGURATIONS nightly)
  set_tests_properties(disguise_every_fault PROPERTIES ENVIRONMENT CLSDF_FAULT_EVERY=1 TIMEOUT 14400 LABELS nightly)
  set_tests_properties(disguise_faults disguise_every_fault
                       PROPERTIES ENVIRONMENT_MODIFICATION ASAN_OPTIONS=string_append::verify_asan_link_order=0)
endif()

# Tests as on a GPU. A sample of them:
function(clsdf_disguised name program)
  add_test(NAME disguise_${name} COMMAND ${program} --color_output=no ${ARGN})
  clsdf_between(disguise_${name})
  set_property(TEST disguise_${name} APPEND PROPERTY ENVIRONMENT CLSDF_DISGUISE=gpu)
  set_tests_properties(disguise_${name} PROPERTIES LABELS disguise)
endfunction()

clsdf_disguised(radix_sort test_radix_sort)
clsdf_disguised(shapes test_transform_shapes)
clsdf_disguised(streams test_transform_streams)
clsdf_disguised(plans test_transform_plans)
clsdf_disguised(sparse_plans test_transform_sparse_plans)
clsdf_disguised(same_bytes test_transform_same_bytes)
clsdf_disguised(kernel_frusta test_transform_kernel_frusta)
clsdf_disguised(callers_memory test_transform_callers_memory)

# Kernels that only a GPU runs, on oclgrind, which calls itself a processor (tests/races).
if(TARGET test_races AND CLSDF_OCLGRIND_DRIVER)
  clsdf_disguised(races test_races --run_test=*_of_a_gpu)
  set_property(TEST disguise_races APPEND PROPERTY ENVIRONMENT CLSDF_CACHE_DIR= CLSDF_SELF_TEST=0 OCLGRIND_DATA_RACES=1
                                                   OCLGRIND_CHECK_API=1 OCL_ICD_VENDORS=${CLSDF_OCLGRIND_DRIVER})
  set_tests_properties(disguise_races PROPERTIES FAIL_REGULAR_EXPRESSION "data race;Invalid;Error;OCLGRIND"
                                                 PASS_REGULAR_EXPRESSION "No errors detected" TIMEOUT 900)
endif()

# and, with -C nightly (scripts/on-disguise), all that use a device, and a sample of the acceptance list.
function(clsdf_as_gpu name program)
  add_test(NAME as_gpu_${name} COMMAND ${program} ${ARGN} CONFIGURATIONS nightly)
  clsdf_between(as_gpu_${name})
  set_property(TEST as_gpu_${name} APPEND PROPERTY ENVIRONMENT CLSDF_DISGUISE=gpu)
  set_tests_properties(as_gpu_${name} PROPERTIES LABELS as_gpu TIMEOUT 3600)
endfunction()
get_property(names GLOBAL PROPERTY CLSDF_TESTS)
list(FILTER names INCLUDE REGEX "^(device|radix_sort|binary_tree|transform_.*|slices_.*|brute_force|prepare|picture|benchmarks|command)$")
foreach(name IN LISTS names)
  clsdf_as_gpu(${name} test_${name} --color_output=no)
endforeach()
clsdf_as_gpu(acceptance acceptance --sampled)
