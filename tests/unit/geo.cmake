downrange_test(geo_vectors_test ${CMAKE_CURRENT_LIST_DIR}/geo_vectors_test.cpp LIBS downrange_geo)
downrange_test(geo_laws_test ${CMAKE_CURRENT_LIST_DIR}/geo_laws_test.cpp LIBS downrange_geo)
downrange_test(geo_refraction_test ${CMAKE_CURRENT_LIST_DIR}/geo_refraction_test.cpp
               LIBS downrange_geo nlohmann_json::nlohmann_json)
downrange_test(geo_nominal_test ${CMAKE_CURRENT_LIST_DIR}/geo_nominal_test.cpp LIBS downrange_geo)
downrange_test(geo_free_fall_test ${CMAKE_CURRENT_LIST_DIR}/geo_free_fall_test.cpp LIBS downrange_geo)
downrange_test(geo_ground_polygon_test ${CMAKE_CURRENT_LIST_DIR}/geo_ground_polygon_test.cpp LIBS downrange_geo ${GeographicLib_LIBRARIES})
