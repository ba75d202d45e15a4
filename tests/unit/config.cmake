downrange_test(unit_config ${CMAKE_CURRENT_LIST_DIR}/config_test.cpp LIBS downrange_config)
