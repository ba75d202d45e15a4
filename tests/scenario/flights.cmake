downrange_test(scenario_launch_test ${CMAKE_CURRENT_LIST_DIR}/launch_test.cpp LIBS downrange_sim downrange_config)
downrange_test(scenario_operator_test ${CMAKE_CURRENT_LIST_DIR}/operator_test.cpp LIBS downrange_archive downrange_stage)
downrange_test(scenario_antenna_mounts_test ${CMAKE_CURRENT_LIST_DIR}/antenna_mounts_test.cpp LIBS downrange_sim)
downrange_test(scenario_mismatch_alarm_test ${CMAKE_CURRENT_LIST_DIR}/mismatch_alarm_test.cpp
               LIBS downrange_sim downrange_config)
downrange_test(scenario_recorded_flights_test ${CMAKE_CURRENT_LIST_DIR}/recorded_flights_test.cpp
               LIBS downrange_experiment downrange_config downrange_archive TIMEOUT 600)
target_sources(scenario_recorded_flights_test PRIVATE ${PROJECT_SOURCE_DIR}/src/app/downrange/recorded_flights.cpp
                                                      ${PROJECT_SOURCE_DIR}/src/app/downrange/shipped_files.cpp)
target_compile_definitions(scenario_recorded_flights_test PRIVATE DOWNRANGE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

# The binaries as a person uses them. Each takes a DDS domain of its own.
downrange_script_test(live_flight_test live_flight_test.sh TIMEOUT 300 TARGETS downrange downranged
                      ARGS $<TARGET_FILE_DIR:downrange> $<TARGET_FILE_DIR:downranged> ${PROJECT_SOURCE_DIR} 171)
downrange_script_test(report_test report_test.sh TIMEOUT 120 TARGETS downrange
                      ARGS $<TARGET_FILE_DIR:downrange> ${PROJECT_SOURCE_DIR})
downrange_script_test(scenario_faults_test faults_test.sh TIMEOUT 600 TARGETS downrange
                      ARGS $<TARGET_FILE_DIR:downrange> ${PROJECT_SOURCE_DIR})
