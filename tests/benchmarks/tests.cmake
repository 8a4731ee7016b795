if(TARGET clsdf_bench)
  clsdf_test(benchmarks judgement.cpp measure.cpp meshes.cpp methods.cpp papers.cpp LABELS benchmarks
             LINK clsdf_bench clsdf::reference OpenCL::OpenCL AS_GPU)
endif()
if(TARGET benchmark_ranks)
  add_test(NAME benchmark_ranks
           COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:benchmark_ranks> -D MPIEXEC=${MPIEXEC_EXECUTABLE}
                   -D COUNT_FLAG=${MPIEXEC_NUMPROC_FLAG} -D RUN_RANKS=${PROJECT_SOURCE_DIR}/cmake/RunRanks.cmake
                   -P ${CMAKE_CURRENT_LIST_DIR}/ranks.cmake)
  set_tests_properties(benchmark_ranks PROPERTIES LABELS benchmarks)
endif()
