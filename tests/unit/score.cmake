find_package(nlohmann_json REQUIRED)
downrange_test(score_test ${CMAKE_CURRENT_LIST_DIR}/score_test.cpp LIBS downrange_score nlohmann_json::nlohmann_json)
downrange_test(score_truth_test ${CMAKE_CURRENT_LIST_DIR}/score_truth_test.cpp LIBS downrange_score)
downrange_test(score_outliers_test ${CMAKE_CURRENT_LIST_DIR}/score_outliers_test.cpp LIBS downrange_score)
