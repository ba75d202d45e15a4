downrange_test(est_async_fusion_test ${CMAKE_CURRENT_LIST_DIR}/est_async_fusion_test.cpp LIBS downrange_est)
downrange_test(est_filter_test ${CMAKE_CURRENT_LIST_DIR}/est_filter_test.cpp LIBS downrange_est)
downrange_test(est_song2015_test ${CMAKE_CURRENT_LIST_DIR}/est_song2015_test.cpp LIBS downrange_est)
downrange_test(est_bias_step_vectors_test ${CMAKE_CURRENT_LIST_DIR}/est_bias_step_vectors_test.cpp LIBS downrange_est)
