clsdf_test(field ${CMAKE_CURRENT_LIST_DIR}/round_trip.cpp ${CMAKE_CURRENT_LIST_DIR}/nrrd.cpp
           ${CMAKE_CURRENT_LIST_DIR}/npy.cpp ${CMAKE_CURRENT_LIST_DIR}/damaged.cpp ${CMAKE_CURRENT_LIST_DIR}/output.cpp
           ${CMAKE_CURRENT_LIST_DIR}/writer.cpp)
