downrange_test(unit_config ${CMAKE_CURRENT_LIST_DIR}/config_test.cpp LIBS downrange_config)
downrange_test(unit_config_calibration ${CMAKE_CURRENT_LIST_DIR}/config_calibration_test.cpp LIBS downrange_config)
downrange_test(unit_config_warnings ${CMAKE_CURRENT_LIST_DIR}/config_warnings_test.cpp LIBS downrange_config)
downrange_test(unit_config_bad ${CMAKE_CURRENT_LIST_DIR}/config_bad_test.cpp LIBS downrange_config)
