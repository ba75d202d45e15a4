downrange_script_test(command_fault_test command_fault_test.sh TARGETS downrange
                      ARGS $<TARGET_FILE_DIR:downrange> ${PROJECT_SOURCE_DIR})
