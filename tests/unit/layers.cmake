add_test(NAME unit_layers COMMAND ${CMAKE_CURRENT_LIST_DIR}/layers_test.sh ${PROJECT_SOURCE_DIR})
set_tests_properties(unit_layers PROPERTIES LABELS unit TIMEOUT 120)
