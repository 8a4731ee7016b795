if(TARGET clsdf_bench)
  clsdf_test(benchmarks ${CMAKE_CURRENT_LIST_DIR}/judgement.cpp ${CMAKE_CURRENT_LIST_DIR}/measure.cpp
             ${CMAKE_CURRENT_LIST_DIR}/meshes.cpp ${CMAKE_CURRENT_LIST_DIR}/methods.cpp ${CMAKE_CURRENT_LIST_DIR}/papers.cpp)
  target_link_libraries(test_benchmarks PRIVATE clsdf_bench clsdf::reference OpenCL::OpenCL)
endif()
if(TARGET benchmark_ranks)
  add_test(NAME benchmark_ranks
           COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:benchmark_ranks> -D MPIEXEC=${MPIEXEC_EXECUTABLE}
                   -D COUNT_FLAG=${MPIEXEC_NUMPROC_FLAG} -D RUN_RANKS=${PROJECT_SOURCE_DIR}/cmake/RunRanks.cmake
                   -P ${CMAKE_CURRENT_LIST_DIR}/ranks.cmake)
endif()
