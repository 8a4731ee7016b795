# A library between a program and the loader of OpenCL (disguise.hpp): a processor as a GPU with memory of its own,
# counts of what is asked of the driver, and calls that fail on purpose.
add_library(clsdf_disguise SHARED ${CMAKE_CURRENT_LIST_DIR}/record.cpp ${CMAKE_CURRENT_LIST_DIR}/gpu.cpp
                                  ${CMAKE_CURRENT_LIST_DIR}/memory.cpp ${CMAKE_CURRENT_LIST_DIR}/calls.cpp
                                  ${CMAKE_CURRENT_LIST_DIR}/failing.cpp ${CMAKE_CURRENT_LIST_DIR}/external.cpp)
target_include_directories(clsdf_disguise PUBLIC ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(clsdf_disguise PRIVATE clsdf_warnings nlohmann_json::nlohmann_json ${CMAKE_DL_LIBS})

# A stand-in for CUDA's driver, libcuda.so.1, in a folder of its own. A program that links it has its cuda.h.
add_library(clsdf_cuda_stand_in SHARED ${CMAKE_CURRENT_LIST_DIR}/cuda/driver.cpp ${CMAKE_CURRENT_LIST_DIR}/cuda/streams.cpp)
target_include_directories(clsdf_cuda_stand_in PRIVATE ${PROJECT_SOURCE_DIR}/tests
                                               INTERFACE ${CMAKE_CURRENT_LIST_DIR}/cuda/include)
target_link_libraries(clsdf_cuda_stand_in PRIVATE clsdf_warnings Threads::Threads)
set_target_properties(clsdf_cuda_stand_in PROPERTIES OUTPUT_NAME cuda VERSION 1 SOVERSION 1
                                                     LIBRARY_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/cuda)

# clsdf_between(<test>...): the library lies between these tests' programs and the loader. LD_PRELOAD is split at blanks,
# LD_LIBRARY_PATH is not.
function(clsdf_between)
  set(modification LD_LIBRARY_PATH=path_list_prepend:$<TARGET_FILE_DIR:clsdf_disguise>
                   ASAN_OPTIONS=string_append::verify_asan_link_order=0)
  set_tests_properties(${ARGN} PROPERTIES ENVIRONMENT LD_PRELOAD=$<TARGET_FILE_NAME:clsdf_disguise>
                                          ENVIRONMENT_MODIFICATION "${modification}")
endfunction()

# clsdf_with_cuda_stand_in(<test> <external>): the program, which links clsdf_cuda_stand_in, sees a GPU that shares memory with
# it; CLSDF_DISGUISE_EXTERNAL is <external>.
function(clsdf_with_cuda_stand_in test external)
  clsdf_between(${test})
  set_property(TEST ${test} APPEND PROPERTY ENVIRONMENT CLSDF_DISGUISE=gpu CLSDF_DISGUISE_EXTERNAL=${external})
endfunction()

clsdf_test(disguise_promises promises.cpp memory_promises.cpp plan_promises.cpp LABELS disguise device moves plan plans LINK clsdf_disguise clsdf::reference clsdf::papers OpenCL::OpenCL)
clsdf_between(disguise_promises)

clsdf_test(disguise_device_meshes device_meshes.cpp LABELS disguise homes mesh topology frusta moves LINK clsdf_disguise clsdf::reference OpenCL::OpenCL)
clsdf_between(disguise_device_meshes)

clsdf_test(disguise_moving_points moving_points.cpp LABELS disguise points plans moves LINK clsdf_disguise clsdf::reference OpenCL::OpenCL)
clsdf_between(disguise_moving_points)

clsdf_test(disguise_pinned_reads pinned_reads.cpp LABELS disguise device LINK clsdf_disguise OpenCL::OpenCL)
clsdf_between(disguise_pinned_reads)

# Kernels that fail, and calls of OpenCL, on a processor and as on a GPU: a sample, and with -C nightly each of them.
clsdf_test_program(disguise_failing failing_kernels.cpp failing_calls.cpp uses.cpp row_uses.cpp)
target_link_libraries(test_disguise_failing PRIVATE clsdf_disguise OpenCL::OpenCL)
# clsdf_failing(<name> <device> <cases> <environment> [<configuration>])
function(clsdf_failing name device cases environment)
  add_test(NAME ${name} COMMAND test_disguise_failing --color_output=no --run_test=${cases} CONFIGURATIONS ${ARGN})
  clsdf_between(${name})
  set_property(TEST ${name} APPEND PROPERTY ENVIRONMENT CLSDF_DISGUISE=${device} ${environment})
  set_tests_properties(${name} PROPERTIES LABELS "disguise;device;calls")
  if(ARGN)
    set_tests_properties(${name} PROPERTIES TIMEOUT 3600 LABELS "disguise;device;calls;nightly")
  endif()
endfunction()
foreach(device processor gpu)
  clsdf_failing(disguise_failing_kernels_${device} ${device} failing_kernels CLSDF_FAULT_SEED=1)
  clsdf_failing(disguise_failing_calls_${device} ${device} failing_calls CLSDF_FAULT_SEED=1)
  foreach(part RANGE 7)
    clsdf_failing(disguise_every_failing_kernel_${device}_${part} ${device} failing_kernels CLSDF_FAULT_PART=${part}/8 nightly)
    clsdf_failing(disguise_every_failing_call_${device}_${part} ${device} failing_calls CLSDF_FAULT_PART=${part}/8 nightly)
  endforeach()
endforeach()

# PoCL answers as other drivers do.
clsdf_test(disguise_drivers drivers.cpp LABELS disguise device LINK clsdf_disguise OpenCL::OpenCL)
clsdf_between(disguise_drivers)

# A GPU that takes memory of CUDA.
clsdf_test(disguise_external_memory external_memory.cpp LABELS disguise device LINK clsdf_disguise OpenCL::OpenCL)
clsdf_between(disguise_external_memory)

# Arrays in memory of CUDA, with semaphores and without.
clsdf_test(cuda_arrays LABELS cuda disguise LINK clsdf_disguise clsdf_cuda_stand_in clsdf::cuda OpenCL::OpenCL)
clsdf_with_cuda_stand_in(cuda_arrays memory+semaphores)
add_test(NAME cuda_arrays_without_semaphores COMMAND test_cuda_arrays --color_output=no)
clsdf_with_cuda_stand_in(cuda_arrays_without_semaphores memory)
set_tests_properties(cuda_arrays_without_semaphores PROPERTIES LABELS "cuda;disguise")

clsdf_with_cuda_stand_in(code_for_amrex_cuda memory+semaphores)

# What jobs ask of a device, and their memory. CLSDF_WRITE_COUNTS=1 writes the numbers into work_counts.tsv. They are those
# of vectors of eight floats on every processor.
clsdf_test_program(disguise_work_counts work_counts.cpp host_memory.cpp)
target_link_libraries(test_disguise_work_counts PRIVATE clsdf_disguise OpenCL::OpenCL)
target_compile_definitions(test_disguise_work_counts PRIVATE CLSDF_SOURCE="${PROJECT_SOURCE_DIR}")
foreach(device processor gpu)
  set(name disguise_work_counts_${device})
  add_test(NAME ${name} COMMAND test_disguise_work_counts --color_output=no)
  clsdf_between(${name})
  set_property(TEST ${name} APPEND PROPERTY ENVIRONMENT CLSDF_DISGUISE=${device} CLSDF_SELF_TEST=0 CLSDF_MAX_FLOAT_WIDTH=8)
  set_tests_properties(${name} PROPERTIES RESOURCE_LOCK work_counts LABELS "disguise;bricks;points;scenes;segments;cutting;plans")
endforeach()

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
  # Its bounds on commands are held to the last number by disguise_work_counts.
  clsdf_turn(0 turn)
  add_test(NAME gpu_counts ${turn}
           COMMAND ${CMAKE_COMMAND} -DCLSDF=${PROJECT_SOURCE_DIR} -DBUILD=${PROJECT_BINARY_DIR} -DPROGRAM=$<TARGET_FILE:clsdf_command>
                   -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/gpu_counts_files -P ${CMAKE_CURRENT_LIST_DIR}/gpu_counts.cmake)
  set_tests_properties(gpu_counts PROPERTIES LABELS disguise ENVIRONMENT_MODIFICATION ASAN_OPTIONS=string_append::verify_asan_link_order=0)
endif()

find_package(Python3 QUIET COMPONENTS Interpreter)
if(Python3_Interpreter_FOUND)
  add_test(NAME on_opencl
           COMMAND ${CMAKE_COMMAND} -DCLSDF=${PROJECT_SOURCE_DIR} -DLIBRARY=$<TARGET_FILE:clsdf_disguise>
                   -DSCRATCH=${CMAKE_CURRENT_BINARY_DIR}/on_opencl -P ${CMAKE_CURRENT_LIST_DIR}/on_opencl.cmake)
  set_tests_properties(on_opencl PROPERTIES LABELS build)
endif()

find_file(CLSDF_OCLGRIND_DRIVER liboclgrind-rt-icd.so PATH_SUFFIXES lib/oclgrind lib64/oclgrind)
mark_as_advanced(CLSDF_OCLGRIND_DRIVER)

# The command with calls that fail: a sample, and with -C nightly each call.
if(TARGET clsdf_command)
  clsdf_test(disguise_faults faults.cpp LABELS disguise device command)
  add_dependencies(test_disguise_faults clsdf_command clsdf_disguise)
  target_compile_definitions(
    test_disguise_faults PRIVATE CLSDF_COMMAND="$<TARGET_FILE:clsdf_command>"
                                 CLSDF_DISGUISE_LIBRARY="$<TARGET_FILE:clsdf_disguise>")
  target_link_libraries(test_disguise_faults PRIVATE clsdf_disguise nlohmann_json::nlohmann_json)
  # Some 60 processes. The seed is fixed, so that no change fails by chance; the nightly tests leave no call out.
  set_tests_properties(disguise_faults PROPERTIES TIMEOUT 900 ENVIRONMENT CLSDF_FAULT_SEED=1)

  # Drivers that are not registered. The second of two in a process is oclgrind: LLVM ends a process with two of PoCL.
  add_library(clsdf_refused_driver MODULE ${CMAKE_CURRENT_LIST_DIR}/refused_driver.cpp)
  target_link_libraries(clsdf_refused_driver PRIVATE clsdf_warnings)
  clsdf_test(unregistered_drivers LABELS disguise device)
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
  set_tests_properties(disguise_is_complete PROPERTIES LABELS disguise)
  set(every_fault "")
  foreach(case on_a_processor on_a_gpu with_all_outputs with_all_outputs_on_a_gpu at_points at_points_on_a_gpu at_many_points in_slabs
               in_slabs_on_a_gpu slice_by_slice while_it_draws a_kernel_that_fails_is_named_and_leaves_no_file)
    set(name disguise_every_fault_${case})
    add_test(NAME ${name} COMMAND test_disguise_faults --color_output=no --run_test=*/*/${case}:*/${case} CONFIGURATIONS nightly)
    set_tests_properties(${name} PROPERTIES ENVIRONMENT CLSDF_FAULT_EVERY=1 TIMEOUT 7200 LABELS "disguise;device;command;nightly")
    list(APPEND every_fault ${name})
  endforeach()
  set_tests_properties(disguise_faults ${every_fault}
                       PROPERTIES ENVIRONMENT_MODIFICATION ASAN_OPTIONS=string_append::verify_asan_link_order=0)
endif()

# Tests as on a GPU have the labels of the tests, and one more. A sample of them, disguise_<test>:
function(clsdf_disguised test)
  add_test(NAME disguise_${test} COMMAND test_${test} --color_output=no ${ARGN})
  clsdf_between(disguise_${test})
  set_property(TEST disguise_${test} APPEND PROPERTY ENVIRONMENT CLSDF_DISGUISE=gpu)
  set(labels_of ${test})
  if(test STREQUAL races)
    set(labels_of races_0)
  endif()
  get_test_property(${labels_of} LABELS labels)
  set_tests_properties(disguise_${test} PROPERTIES LABELS "${labels};disguise")
endfunction()

clsdf_disguised(radix_sort)
clsdf_disguised(accuracy_shapes)
clsdf_disguised(calls_streams)
clsdf_disguised(plans_grids)
clsdf_disguised(sparse_plans)
clsdf_disguised(calls_same_bytes)
clsdf_disguised(frusta_kernel_frusta)
clsdf_disguised(targets_callers_memory)
clsdf_disguised(segments_exact_signs)
clsdf_disguised(segments_links)
clsdf_disguised(plans_links)
clsdf_disguised(cutting_fraction_plans)
if(TARGET test_conformance_distances)
  clsdf_disguised(conformance_distances)
  set_tests_properties(disguise_conformance_distances PROPERTIES FIXTURES_REQUIRED conformance)
endif()

# Kernels that only a GPU runs, on oclgrind, which calls itself a processor (tests/races). It does not know a mark that
# LLVM's inlining leaves in the kernels of cut cells (llvm.experimental.noalias.scope.decl), so these are not optimised.
if(TARGET test_races AND CLSDF_OCLGRIND_DRIVER)
  clsdf_turn(1 turn)
  clsdf_disguised(races --run_test=*_of_a_gpu ${turn})
  add_test(NAME disguise_races_of_cut_cells COMMAND test_races --color_output=no --run_test=cut_cells_in_memory_of_one)
  clsdf_between(disguise_races_of_cut_cells)
  set_property(TEST disguise_races_of_cut_cells APPEND PROPERTY ENVIRONMENT CLSDF_DISGUISE=gpu OCLGRIND_BUILD_OPTIONS=-cl-opt-disable)
  set_property(TEST disguise_races_of_cut_cells PROPERTY LABELS "cutting;disguise")
  foreach(test disguise_races disguise_races_of_cut_cells)
    set_property(TEST ${test} APPEND PROPERTY ENVIRONMENT CLSDF_CACHE_DIR= CLSDF_SELF_TEST=0 OCLGRIND_DATA_RACES=1
                                              OCLGRIND_CHECK_API=1 OCL_ICD_VENDORS=${CLSDF_OCLGRIND_DRIVER})
    set_tests_properties(${test} PROPERTIES FAIL_REGULAR_EXPRESSION "data race;Invalid;Error;OCLGRIND"
                                            PASS_REGULAR_EXPRESSION "No errors detected" TIMEOUT 900)
  endforeach()
endif()

# and, with -C nightly (scripts/on-disguise), all that use a device, and a sample of the acceptance list: as_gpu_<test>.
function(clsdf_as_gpu test program)
  add_test(NAME as_gpu_${test} COMMAND ${program} ${ARGN} CONFIGURATIONS nightly)
  clsdf_between(as_gpu_${test})
  set_property(TEST as_gpu_${test} APPEND PROPERTY ENVIRONMENT CLSDF_DISGUISE=gpu)
  get_test_property(${test} LABELS labels)
  set_tests_properties(as_gpu_${test} PROPERTIES LABELS "${labels};as_gpu" TIMEOUT 3600)
endfunction()
get_property(tests GLOBAL PROPERTY CLSDF_TESTS_AS_GPU)
foreach(test IN LISTS tests)
  clsdf_as_gpu(${test} test_${test} --color_output=no)
endforeach()
clsdf_as_gpu(acceptance acceptance --sampled)
if(TARGET test_prepare)
  clsdf_as_gpu(prepare_0 test_prepare --color_output=no)
endif()
