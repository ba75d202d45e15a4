downrange_test(est_async_fusion_test ${CMAKE_CURRENT_LIST_DIR}/est_async_fusion_test.cpp LIBS downrange_est)
downrange_test(est_filter_test ${CMAKE_CURRENT_LIST_DIR}/est_filter_test.cpp LIBS downrange_est)
downrange_test(est_song2015_test ${CMAKE_CURRENT_LIST_DIR}/est_song2015_test.cpp LIBS downrange_est)
downrange_test(est_bias_step_vectors_test ${CMAKE_CURRENT_LIST_DIR}/est_bias_step_vectors_test.cpp LIBS downrange_est)
downrange_test(est_joint_test ${CMAKE_CURRENT_LIST_DIR}/est_joint_test.cpp LIBS downrange_est)
downrange_test(est_imm_test ${CMAKE_CURRENT_LIST_DIR}/est_imm_test.cpp LIBS downrange_est)
downrange_test(est_consistency_test ${CMAKE_CURRENT_LIST_DIR}/est_consistency_test.cpp LIBS downrange_est)
downrange_test(est_assignment_test ${CMAKE_CURRENT_LIST_DIR}/est_assignment_test.cpp LIBS downrange_est)
downrange_test(est_input_estimation_test ${CMAKE_CURRENT_LIST_DIR}/est_input_estimation_test.cpp
               LIBS downrange_est nlohmann_json::nlohmann_json)
downrange_test(est_track_fusion_test ${CMAKE_CURRENT_LIST_DIR}/est_track_fusion_test.cpp
               LIBS downrange_est nlohmann_json::nlohmann_json)
downrange_test(est_parallax_test ${CMAKE_CURRENT_LIST_DIR}/est_parallax_test.cpp
               LIBS downrange_est nlohmann_json::nlohmann_json)
downrange_test(est_track_association_test ${CMAKE_CURRENT_LIST_DIR}/est_track_association_test.cpp LIBS downrange_est)
downrange_test(est_alpha_beta_test ${CMAKE_CURRENT_LIST_DIR}/est_alpha_beta_test.cpp
               LIBS downrange_est nlohmann_json::nlohmann_json)
downrange_test(est_contract_test ${CMAKE_CURRENT_LIST_DIR}/est_contract_test.cpp LIBS downrange_est)
downrange_test(est_allocation_test ${CMAKE_CURRENT_LIST_DIR}/est_allocation_test.cpp LIBS downrange_est)
downrange_test(est_pseudo_measurement_test ${CMAKE_CURRENT_LIST_DIR}/est_pseudo_measurement_test.cpp LIBS downrange_est)
downrange_test(est_two_stage_test ${CMAKE_CURRENT_LIST_DIR}/est_two_stage_test.cpp LIBS downrange_est downrange_sim)
downrange_test(est_ts_test ${CMAKE_CURRENT_LIST_DIR}/est_ts_test.cpp LIBS downrange_est)
downrange_test(est_track_level_test ${CMAKE_CURRENT_LIST_DIR}/est_track_level_test.cpp LIBS downrange_est)
downrange_test(est_quick_look_test ${CMAKE_CURRENT_LIST_DIR}/est_quick_look_test.cpp LIBS downrange_est)
