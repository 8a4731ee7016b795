clsdf_test(device ${CMAKE_CURRENT_LIST_DIR}/device.cpp ${CMAKE_CURRENT_LIST_DIR}/choice.cpp
           ${CMAKE_CURRENT_LIST_DIR}/errors.cpp ${CMAKE_CURRENT_LIST_DIR}/buffer_pool.cpp ${CMAKE_CURRENT_LIST_DIR}/program_cache.cpp
           ${CMAKE_CURRENT_LIST_DIR}/build_records.cpp
           ${CMAKE_CURRENT_LIST_DIR}/shared_structs.cpp ${CMAKE_CURRENT_LIST_DIR}/host_filling.cpp
           ${CMAKE_CURRENT_LIST_DIR}/vectors.cpp ${CMAKE_CURRENT_LIST_DIR}/known_faults.cpp)
target_link_libraries(test_device PRIVATE OpenCL::OpenCL)
# A process of its own: the loader looks for drivers once.
clsdf_test(no_device ${CMAKE_CURRENT_LIST_DIR}/no_device.cpp)
# Likewise: PoCL starts its threads once.
clsdf_test(floating_point ${CMAKE_CURRENT_LIST_DIR}/floating_point.cpp)
target_link_libraries(test_floating_point PRIVATE clsdf::reference)
