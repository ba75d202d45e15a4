find_package(nlohmann_json REQUIRED)
downrange_test(sim_trajectory_test ${CMAKE_CURRENT_LIST_DIR}/sim_trajectory_test.cpp LIBS downrange_sim)
downrange_test(sim_sensors_test ${CMAKE_CURRENT_LIST_DIR}/sim_sensors_test.cpp LIBS downrange_sim)
downrange_test(sim_scenario_test ${CMAKE_CURRENT_LIST_DIR}/sim_scenario_test.cpp LIBS downrange_sim)
downrange_test(sim_score_test ${CMAKE_CURRENT_LIST_DIR}/sim_score_test.cpp
               LIBS downrange_sim nlohmann_json::nlohmann_json)
downrange_test(sim_experiment_test ${CMAKE_CURRENT_LIST_DIR}/sim_experiment_test.cpp
               LIBS downrange_sim nlohmann_json::nlohmann_json)
downrange_test(sim_paper_experiments_test ${CMAKE_CURRENT_LIST_DIR}/sim_paper_experiments_test.cpp LIBS downrange_sim)
downrange_test(sim_kim2011_test ${CMAKE_CURRENT_LIST_DIR}/sim_kim2011_test.cpp LIBS downrange_sim)
