downrange_test(sim_trajectory_test ${CMAKE_CURRENT_LIST_DIR}/sim_trajectory_test.cpp LIBS downrange_sim)
downrange_test(sim_sensors_test ${CMAKE_CURRENT_LIST_DIR}/sim_sensors_test.cpp LIBS downrange_sim)
downrange_test(sim_scenario_test ${CMAKE_CURRENT_LIST_DIR}/sim_scenario_test.cpp LIBS downrange_sim)
downrange_test(sim_orbit_pass_test ${CMAKE_CURRENT_LIST_DIR}/sim_orbit_pass_test.cpp LIBS downrange_sim)
