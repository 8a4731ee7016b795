if(TARGET clsdf_bench)
  clsdf_test(benchmarks ${CMAKE_CURRENT_LIST_DIR}/judgement.cpp ${CMAKE_CURRENT_LIST_DIR}/measure.cpp
             ${CMAKE_CURRENT_LIST_DIR}/meshes.cpp ${CMAKE_CURRENT_LIST_DIR}/methods.cpp ${CMAKE_CURRENT_LIST_DIR}/papers.cpp)
  target_link_libraries(test_benchmarks PRIVATE clsdf_bench clsdf::reference OpenCL::OpenCL)
endif()
