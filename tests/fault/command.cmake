add_test(NAME command_fault_test COMMAND ${CMAKE_CURRENT_LIST_DIR}/command_fault_test.sh $<TARGET_FILE_DIR:downrange>
                                         ${PROJECT_SOURCE_DIR})
set_tests_properties(command_fault_test PROPERTIES TIMEOUT 120 LABELS fault)
