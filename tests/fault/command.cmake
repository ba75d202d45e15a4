downrange_script_test(command_fault_test command_fault_test.sh TARGETS downrange downranged
                      ARGS $<TARGET_FILE_DIR:downrange> ${PROJECT_SOURCE_DIR} $<TARGET_FILE_DIR:downranged>)
